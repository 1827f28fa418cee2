"""Modbus programs of others, for tests: mbpoll, pymodbus, socat; and modbus_tool, ours without an amplifier.

Everything here ends with the test: children are killed, waits have an end.
"""
import contextlib
import functools
import os
import subprocess
import sys
import time

PATIENCE_S = 20  # longer than anything here may take on a busy machine


def tool():
    path = os.environ.get("MODBUS_TOOL")
    if not path:
        raise RuntimeError("set the environment variable MODBUS_TOOL to the path of modbus_tool")
    return path


@functools.lru_cache
def pymodbus_python():
    """A Python that has pymodbus: Debian's, where the tests run with another one."""
    for python in (sys.executable, "/usr/bin/python3"):
        done = subprocess.run([python, "-c", "import pymodbus.server"], capture_output=True, timeout=PATIENCE_S)
        if done.returncode == 0:
            return python
    raise RuntimeError("python3-pymodbus is not installed: cmake/setup-packages test")


class Child:
    """A program that says on a line of its own when it is ready, and ends when its input does."""

    def __init__(self, *words, errors=None):
        self.process = subprocess.Popen([str(w) for w in words], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=errors, text=True)
        self.where = self.read_line().removeprefix("listening").strip()

    def read_line(self):
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self.process.args} has ended: {self.process.wait(PATIENCE_S)}")
        return line.rstrip("\n")

    def ask(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        return self.read_line()

    def finish(self):
        """What it says at its end."""
        out, _ = self.process.communicate(timeout=PATIENCE_S)
        return out

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            with contextlib.suppress(OSError):
                self.process.stdin.close()
            try:
                self.process.wait(2)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self.process.stdout.close()


def serve_tcp():
    """Our server; `where` is its port."""
    return Child(tool(), "serve", "tcp")


def serve_rtu(link):
    """Our server on a pseudo-terminal; `where` is `link`."""
    return Child(tool(), "serve", "rtu", link)


class Link(Child):
    """Our link to a device: `ask` sends it a line (modbus_tool.cpp says which) and returns the answer."""

    def __init__(self, address, timeout=0.5, retries=3, log=None):
        words = [tool(), "ask", address, timeout, retries] + ([log] if log else [])
        self.process = subprocess.Popen([str(w) for w in words], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        text=True)


@contextlib.contextmanager
def terminal_pair(folder):
    """Two terminals joined by socat: what is written to one is read from the other."""
    ends = [str(folder / name) for name in ("near", "far")]
    with subprocess.Popen(["socat", *(f"pty,raw,echo=0,link={end}" for end in ends)]) as socat:
        try:
            deadline = time.monotonic() + PATIENCE_S
            while not all(os.path.exists(end) for end in ends):
                if time.monotonic() > deadline or socat.poll() is not None:
                    raise RuntimeError("socat has made no terminals")
                time.sleep(0.01)
            yield ends
        finally:
            socat.terminate()
            socat.wait(PATIENCE_S)


PYMODBUS_SERVER = """
import asyncio, sys
from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.server import StartAsyncSerialServer, StartAsyncTcpServer
from pymodbus.transaction import ModbusRtuFramer

def block(value):
    return ModbusSequentialDataBlock(0, [value(i) for i in range(200)])

async def main(kind, *where):
    store = ModbusSlaveContext(di=block(lambda i: i % 3 == 0), co=block(lambda i: False), hr=block(lambda i: 0),
                               ir=block(lambda i: 7 * i + 1), zero_mode=True)
    context = ModbusServerContext(slaves={1: store}, single=False)
    if kind == "tcp":
        server = await StartAsyncTcpServer(context=context, address=("127.0.0.1", 0), defer_start=True)
        task = asyncio.ensure_future(server.serve_forever())
        while server.server is None or not server.server.sockets:
            await asyncio.sleep(0.01)
        print("listening", server.server.sockets[0].getsockname()[1], flush=True)
    else:
        server = await StartAsyncSerialServer(context=context, framer=ModbusRtuFramer, port=where[0],
                                              baudrate=115200, parity="N", defer_start=True)
        await server.start()
        task = asyncio.ensure_future(server.serve_forever())
        print("listening", where[0], flush=True)
    await asyncio.get_running_loop().run_in_executor(None, sys.stdin.read)  # until the test ends
    task.cancel()

asyncio.run(main(*sys.argv[1:]))
"""

PYMODBUS_CLIENT = """
import json, sys
from pymodbus.client import ModbusSerialClient, ModbusTcpClient
from pymodbus.transaction import ModbusRtuFramer

def said(answer):
    if answer.isError():
        return str(answer)
    return [int(v) for v in (answer.registers if hasattr(answer, "registers") else answer.bits)]

kind, where = sys.argv[1:]
client = (ModbusTcpClient("127.0.0.1", port=int(where), timeout=5) if kind == "tcp" else
          ModbusSerialClient(where, framer=ModbusRtuFramer, baudrate=115200, parity="N", timeout=5))
assert client.connect()
answers = []
for line in json.load(sys.stdin):
    verb, *arguments = line
    answer = getattr(client, verb)(*arguments, slave=1)
    answers.append(None if verb.startswith("write") and not answer.isError() else said(answer))
client.close()
print(json.dumps(answers))
"""


def pymodbus_server(kind, *where):
    """A pymodbus server with the tables of counting_bank.hpp; `where` is its port or terminal."""
    # It reports every exception that it answers as an error.
    return Child(pymodbus_python(), "-c", PYMODBUS_SERVER, kind, *where, errors=subprocess.DEVNULL)
