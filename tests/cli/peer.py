"""The amplifier of pymodbus (tests/support/peer_amplifier.py) as a process beside a test."""
import functools
import json
import subprocess
import sys
from pathlib import Path

from program import ROOT

PROFILE = ROOT / "profiles/integer_drive.json"


@functools.cache
def peer_python():
    """An interpreter that has pymodbus: this one, or the system's."""
    for python in (sys.executable, "/usr/bin/python3"):
        done = subprocess.run([python, "-c", "import pymodbus.server"], capture_output=True, check=False)
        if done.returncode == 0:
            return python
    raise RuntimeError("no Python with pymodbus (Debian: python3-pymodbus)")


class Peer:
    """Serves the second profile until it is closed; `url` is for --connect."""

    def __init__(self, *options, profile=PROFILE, rtu=None, log=None):
        words = [peer_python(), ROOT / "tests/support/peer_amplifier.py", profile, *options]
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
