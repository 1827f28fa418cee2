"""A TCP proxy between a Modbus client and its device that disturbs what goes through it.

In a test:

    from fault_proxy import FaultProxy

    with FaultProxy(("127.0.0.1", device_port), seed=7, rates={"drop": 0.02, "cut": 0.01}) as proxy:
        ...  # talk to 127.0.0.1 at proxy.port
        proxy.faults  # what was done, in order: Fault(kind, direction, frame, hex)

    FaultProxy(address, plan=[("answer", "drop"), ("answer", None), ("request", "cut")])

By itself, until its standard input ends; prints "listening PORT", and at the end the faults:

    fault_proxy.py HOST:PORT [--seed N] [--rate KIND=P]...

Frames are those of Modbus TCP, each way cut where its header says. `rates` gives the probability of
each kind per frame, drawn from the seed; which frames come in which order depends on the timing of
both sides, so that a seed repeats the draws, not always the run. `plan` instead says what happens
to the frames one after another: each entry waits for the next frame of its direction; when all are
done nothing more is disturbed. Kinds:

    drop       the frame goes nowhere
    delay      it goes on later, by a time drawn from `delay` [s]; what comes after it waits. A request may
               so arrive after its client has given it up, as over a real network
    cut        both connections are closed, the frame is lost
    cut_after  the frame goes on, then both are closed
    corrupt    one bit of it is turned (answers only, unless corrupt_requests: TCP has check sums of
               its own, and a turned bit in a request would be a wrong command)
    duplicate  it goes on twice
    half       its first half goes on, the rest never does
    garbage    random bytes go instead (answers only, as corrupt)

`armed` may be set to False and True at any time: disarmed, everything goes through.
"""
import argparse
import collections
import random
import socket
import struct
import sys
import threading

Fault = collections.namedtuple("Fault", "kind direction frame hex")

KINDS = ("drop", "delay", "cut", "cut_after", "corrupt", "duplicate", "half", "garbage")
ANSWERS_ONLY = ("corrupt", "garbage")
POLL_S = 0.05  # how soon a thread notices that it is to end


class FaultProxy:

    def __init__(self, device, *, seed=0, rates=None, plan=None, delay=(0.01, 0.3), corrupt_requests=False):
        unknown = (set(rates or {}) | {kind for _, kind in plan or () if kind}) - set(KINDS)
        if unknown:
            raise ValueError(f"unknown faults {sorted(unknown)}: allowed: {', '.join(KINDS)}")
        self.device, self.rates, self.delay = device, dict(rates or {}), delay
        self.plan = collections.deque(plan or ())
        self.corrupt_requests = corrupt_requests
        self.armed = True
        self.faults = []
        self.frames = collections.Counter()
        self._random = random.Random(seed)
        self._lock = threading.Lock()
        self._stopped = threading.Event()
        self._pairs = []
        self._threads = []
        self._listener = socket.create_server(("127.0.0.1", 0), backlog=64)
        self._listener.settimeout(POLL_S)
        self.port = self._listener.getsockname()[1]
        self._start(self._accept)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()

    def stop(self):
        """Closes every connection and ends the threads."""
        self._stopped.set()
        self._listener.close()
        self.cut_all()
        for thread in list(self._threads):
            thread.join(timeout=5)

    def cut_all(self):
        """Closes the connections that are open now; new ones are taken."""
        with self._lock:
            pairs, self._pairs = self._pairs, []
        for pair in pairs:
            _close(pair)

    def _start(self, work, *arguments):
        thread = threading.Thread(target=work, args=arguments, daemon=True)
        self._threads.append(thread)
        thread.start()

    def _accept(self):
        while not self._stopped.is_set():
            try:
                client, _ = self._listener.accept()
            except socket.timeout:
                continue
            except OSError:
                return
            try:
                device = socket.create_connection(self.device, timeout=5)
            except OSError:
                client.close()
                continue
            pair = (client, device)
            for end in pair:
                end.settimeout(POLL_S)
                end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            with self._lock:
                self._pairs.append(pair)
            self._start(self._pump, pair, client, device, "request")
            self._start(self._pump, pair, device, client, "answer")

    def _pump(self, pair, source, sink, direction):
        buffer = b""
        try:
            while not self._stopped.is_set():
                try:
                    received = source.recv(4096)
                except socket.timeout:
                    continue
                if not received:
                    break
                buffer += received
                while (size := _frame_size(buffer)) and len(buffer) >= size:
                    frame, buffer = buffer[:size], buffer[size:]
                    if not self._pass(frame, sink, direction):
                        return
        except OSError:
            pass  # the other thread has closed the pair, or one side has gone
        finally:
            _close(pair)

    def _pass(self, frame, sink, direction):
        """Sends the frame on, or what becomes of it; False: the connection is over."""
        with self._lock:
            kind = self._draw(direction)
            spoiled = self._spoil(frame, kind)
            wait = self._random.uniform(*self.delay)
            self.frames[direction] += 1
            if kind:
                self.faults.append(Fault(kind, direction, self.frames[direction], frame.hex(" ")))
        if kind == "delay":
            self._stopped.wait(wait)
        if spoiled:
            sink.sendall(spoiled)
        return kind not in ("cut", "cut_after")

    def _draw(self, direction):
        if not self.armed:
            return None
        if self.plan:
            if self.plan[0][0] != direction:
                return None
            return self.plan.popleft()[1]
        draw = self._random.random()
        for kind in KINDS:
            if direction == "request" and kind in ANSWERS_ONLY and not self.corrupt_requests:
                continue
            draw -= self.rates.get(kind, 0)
            if draw < 0:
                return kind
        return None

    def _spoil(self, frame, kind):
        if kind in ("drop", "cut"):
            return b""
        if kind == "duplicate":
            return frame + frame
        if kind == "half":
            return frame[:len(frame) // 2]
        if kind == "garbage":
            return self._random.randbytes(self._random.randint(1, 40))
        if kind == "corrupt":
            bit = self._random.randrange(8 * len(frame))
            changed = bytearray(frame)
            changed[bit // 8] ^= 1 << bit % 8
            return bytes(changed)
        return frame


def _frame_size(buffer):
    """Bytes of the frame that begins so; 0 while its header is not whole."""
    return 6 + struct.unpack(">H", buffer[4:6])[0] if len(buffer) >= 6 else 0


def _close(pair):
    for end in pair:
        try:
            end.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        end.close()


def main():
    parser = argparse.ArgumentParser(description="Disturbs Modbus TCP")
    parser.add_argument("device", help="HOST:PORT")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rate", action="append", default=[], metavar="KIND=P")
    arguments = parser.parse_args()
    host, port = arguments.device.rsplit(":", 1)
    rates = {kind: float(p) for kind, p in (rate.split("=") for rate in arguments.rate)}
    with FaultProxy((host, int(port)), seed=arguments.seed, rates=rates) as proxy:
        print("listening", proxy.port, flush=True)
        for _ in sys.stdin:
            pass
        for fault in proxy.faults:
            print(*fault, flush=True)


if __name__ == "__main__":
    main()
