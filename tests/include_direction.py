"""A room includes only rooms below it. This table is the diagram of the house."""
import pathlib, re, sys

MAY_INCLUDE = {
    "core": set(),
    "nodes": {"core"},
    "circuits": {"core"},
    "controllers": {"core"},
    "mechanics": {"core", "circuits"},
    "verification": {"core", "circuits", "controllers", "mechanics"},
    "cosim": {"core", "circuits", "controllers", "mechanics"},
    "lanes": {"core", "circuits", "controllers", "mechanics", "cosim"},
    "passivity": {"core", "circuits", "controllers", "mechanics", "cosim"},
    "two_port": {"core", "circuits", "controllers", "mechanics", "cosim", "passivity"},
    "robustness": {"core", "circuits", "controllers", "mechanics", "cosim", "passivity"},
    "documents": {"core"},
    "modbus": {"core"},
    "amplifiers": {"core", "documents", "modbus"},
    "twin": {"core", "circuits", "mechanics", "cosim", "documents", "modbus", "amplifiers"},
    "identification": {"core", "circuits", "mechanics", "amplifiers"},
    "tuning": {"core", "circuits", "controllers", "mechanics", "cosim", "passivity", "amplifiers", "identification"},
    "plots": {"core", "documents"},
    "studies": {"core", "circuits", "controllers", "mechanics", "verification", "cosim", "lanes", "passivity", "two_port", "robustness", "documents", "amplifiers", "twin", "identification", "tuning", "plots"},
    "sweeps": {"core", "nodes", "circuits", "controllers", "mechanics", "cosim", "passivity", "documents", "plots", "studies"},
    "synthesis": {"core", "circuits", "controllers", "mechanics", "cosim", "passivity", "documents", "plots", "studies"},
    "regression": {"core", "documents", "plots", "studies", "sweeps", "synthesis"},
    "app": {"core", "nodes", "documents", "modbus", "amplifiers", "twin", "identification", "tuning", "plots", "studies", "sweeps", "synthesis", "regression"},
}
root = pathlib.Path(__file__).resolve().parent.parent / "src" / "gyrator"
wrong = []
for room in sorted(p for p in root.iterdir() if p.is_dir()):
    for path in sorted(room.glob("*.[ch]pp")):
        for number, line in enumerate(path.read_text().splitlines(), 1):
            match = re.match(r'#include "gyrator/(\w+)/', line)
            if match and match[1] not in MAY_INCLUDE[room.name] | {room.name}:
                wrong.append(f"{path.relative_to(root)}:{number}: {room.name} must not include {match[1]}")
print("\n".join(wrong) or "every include points downwards")
sys.exit(bool(wrong))
