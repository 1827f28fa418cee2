"""The amplifier of pymodbus (tests/support/peer_amplifier.py) as a process beside a test."""
import json
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from modbus_peers import pymodbus_python
from program import ROOT

PROFILE = ROOT / "profiles/integer_drive.json"


class Peer:
    """Serves the second profile until it is closed; `url` is for --connect."""

    def __init__(self, *options, profile=PROFILE, rtu=None, log=None):
        words = [pymodbus_python(), ROOT / "tests/support/peer_amplifier.py", profile, *options]
        words += ["--rtu", rtu] if rtu else []
        words += ["--log", log] if log else []
        self.log = log
        self.process = subprocess.Popen([str(word) for word in words], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, text=True)
        kind, where = self.process.stdout.readline().split()
        self.url = f"tcp://127.0.0.1:{where}" if kind == "port" else f"rtu://{where}?baud=115200&parity=N&stop=1"

    def writes(self):
        """Every write that arrived: {register, value}."""
        if not Path(self.log).exists():
            return []
        return [json.loads(line) for line in Path(self.log).read_text(encoding="utf-8").splitlines()]

    def close(self):
        self.process.stdin.close()
        self.process.wait(timeout=10)
        self.process.stdout.close()
