"""A Modbus amplifier that shares no code with gyrator: pymodbus serves the registers of a profile,
and behind them a motor is integrated in plain Python.

    peer_amplifier.py profiles/integer_drive.json [--rtu LINK] [--resistance 1.5] ...

Prints "port N" (TCP, on the loopback) or "device LINK" (RTU on a pseudo-terminal) when it answers, and
ends when its standard input is closed. Between captures time is real; a capture is computed when its
state is first asked for. The electrical side is exact over a quarter of the 100 us tick with the speed
held, the mechanical side explicit, so that results are good to about 0.1 %.
"""
import argparse
import asyncio
import json
import logging
import math
import os
import random
import signal
import struct
import subprocess
import sys
import threading
import time

from pymodbus.datastore import ModbusServerContext
from pymodbus.interfaces import IModbusSlaveContext
from pymodbus.server.async_io import ModbusSerialServer, ModbusTcpServer
from pymodbus.transaction import ModbusRtuFramer, ModbusSocketFramer

TICK = 1e-4
PARTS = 4
FORMATS = {"bit": ">H", "u16": ">H", "i16": ">h", "u32": ">I", "i32": ">i", "u64": ">Q", "f32": ">f", "f64": ">d"}
PREFIXES = {"": 1, "u": 1e-6, "m": 1e-3, "k": 1e3}


def unit_factor(unit):
    """Of the units that profiles here use: a prefix before the whole unit."""
    for symbol in ("ohm", "A", "V", "F", "Hz", "s", "rad/s", "rad", "K", "N.m.s/rad", "H"):
        if unit.endswith(symbol) and unit[:-len(symbol)] in PREFIXES:
            return PREFIXES[unit[:-len(symbol)]]
    if unit == "":
        return 1
    raise ValueError(f"unit {unit}")


class Number:
    """A register or the first sample of a window: where it is and how it is written there."""

    def __init__(self, entry, order, table):
        self.name = entry.get("name", "")
        self.table = entry.get("table", table)
        self.address = entry["address"]
        self.kind = entry.get("type", "bit")
        self.order = entry.get("order", order)
        self.scale, self.offset = entry.get("scale", 1), entry.get("offset", 0)
        self.factor = unit_factor(entry.get("unit", ""))
        self.codes = entry.get("codes", {})
        self.bits = entry.get("bits")
        self.words = struct.calcsize(FORMATS[self.kind]) // 2
        self.sentinel = entry.get("not_implemented")
        access = entry.get("access", "read_write" if self.table in ("coil", "holding") else "read")
        self.readable, self.writable = access != "write", access != "read"
        self.low, self.high = self.bound(entry.get("min")), self.bound(entry.get("max"))

    def bound(self, value):
        return None if value is None else float(value) * self.factor

    def arrange(self, words):
        """Between the most significant word first and the device's order; its own inverse."""
        if self.order in ("BADC", "DCBA"):
            words = [(w >> 8) | ((w & 255) << 8) for w in words]
        if self.order in ("CDAB", "DCBA"):
            words = words[::-1]
        return words

    def decode(self, words):
        raw = struct.unpack(FORMATS[self.kind], struct.pack(f">{self.words}H", *self.arrange(words)))[0]
        if self.bits:
            raw = (raw >> self.bits["first"]) & ((1 << self.bits.get("count", 1)) - 1)
        return (raw * self.scale + self.offset) * self.factor

    def encode(self, value, old=None):
        raw = (value / self.factor - self.offset) / self.scale
        if self.kind[0] != "f":
            size = 8 * struct.calcsize(FORMATS[self.kind])
            low, high = (-(1 << size - 1), (1 << size - 1) - 1) if self.kind[0] == "i" else (0, (1 << size) - 1)
            raw = min(max(round(raw), low), high)
        if self.bits:
            whole = struct.unpack(FORMATS[self.kind], struct.pack(f">{self.words}H", *self.arrange(old)))[0]
            mask = ((1 << self.bits.get("count", 1)) - 1) << self.bits["first"]
            raw = (whole & ~mask) | (raw << self.bits["first"] & mask)
        return self.arrange(list(struct.unpack(f">{self.words}H", struct.pack(FORMATS[self.kind], raw))))


class Motor:
    """Winding, rotor and branch under a command; everything in SI units."""

    def __init__(self, p):
        self.p = p
        self.drive = self.current = self.capacitor = self.speed = self.angle = 0.0
        self.rise = p.winding_rise
        self.terminal = 0.0
        self.late = [0.0] * max(0, round(p.delay / TICK))

    def resistance(self):
        return self.p.resistance * (1 + 0.00393 * self.rise)

    def tick(self, command, enabled, mode, s):
        """One tick of 100 us under a held command; `s` are the settings."""
        p = self.p
        if self.late:
            self.late.append(command)
            command = self.late.pop(0)
        h = TICK / PARTS
        R, L, K = self.resistance(), p.inductance, p.torque_constant
        cancelled = s["cancellation_resistance"] if enabled else 0
        branch = s["damping_connected"] != 0
        R1, C = s["damping_resistance"], s["damping_capacitance"]
        lag = math.exp(-2 * math.pi * p.bandwidth * h)
        voltage_mode = enabled and mode == "voltage"
        for _ in range(PARTS):
            wanted = command
            if enabled and s["back_emf_damping"]:
                emf = self.terminal - s["back_emf_resistance"] * self.current
                less = s["back_emf_damping"] * emf / K ** 2
                wanted -= less * (R if voltage_mode else 1)
            self.drive = wanted + (self.drive - wanted) * lag if enabled else 0.0
            emf = K * self.speed
            # di/dt = (-a i + e) / L
            if voltage_mode:
                a, e = R - cancelled, self.drive - emf
            elif branch:
                a, e = R - cancelled + R1, R1 * self.drive + self.capacitor - emf
            else:
                a, e = None, None
            if a is None:
                mean = self.current = self.drive
            elif abs(a) > 1e-9:
                end, rate = e / a, a / L
                left = math.exp(-rate * h)
                mean = end + (self.current - end) * (1 - left) / (rate * h)
                self.current = end + (self.current - end) * left
            else:
                mean = self.current + e / L * h / 2
                self.current += e / L * h
            if voltage_mode:
                self.terminal = self.drive + cancelled * self.current
            elif branch:
                through = self.drive - mean
                if C > 0:
                    self.capacitor += through * h / C
                else:
                    self.capacitor = 0.0
                self.terminal = self.capacitor + R1 * (self.drive - self.current)
            else:
                self.terminal = R * self.current + emf
            self.move(K * mean, h)
            loss = R * mean * mean
            self.rise += (loss - self.rise / p.thermal_resistance) / p.thermal_capacity * h

    def move(self, torque, h):
        p, w = self.p, self.speed
        if w == 0:
            if abs(torque) <= p.coulomb_friction:
                return
            dry = math.copysign(p.coulomb_friction, torque)
        else:
            dry = math.copysign(p.coulomb_friction, w)
        new = w + (torque - dry - p.damping * w) / p.inertia * h
        if w != 0 and new * w < 0:
            new = 0.0
        self.angle += (w + new) / 2 * h
        self.speed = new


def prbs_bits():
    shift, bits = 0x7fff, []
    for _ in range((1 << 15) - 1):
        bits.append(shift & 1)
        shift = (shift >> 1) | (((shift ^ (shift >> 1)) & 1) << 14)
    return bits


PRBS = prbs_bits()


def command_at(t, g):
    if t < 0 or t >= g["duration"]:
        return 0.0
    o, a, f, d = g["offset"], g["amplitude"], g["frequency"], g["duration"]
    if g["kind"] == "step":
        return o + (a if t >= d / 4 else 0)
    if g["kind"] == "sine":
        return o + a * math.sin(2 * math.pi * f * t)
    if g["kind"] == "chirp":
        return o + a * math.sin(2 * math.pi * (f * t + (g["end_frequency"] - f) * t * t / (2 * d)))
    if g["kind"] == "prbs":
        return o + (a if PRBS[int(f * t + 1e-9) % len(PRBS)] else -a)
    return o


class Amplifier(IModbusSlaveContext):
    """The profile's registers, and what they do."""

    SETTINGS = {"cancellation_resistance": 0.0, "damping_resistance": 10.0, "damping_capacitance": 0.0,
                "damping_connected": 0.0, "back_emf_damping": 0.0, "back_emf_resistance": 0.0}
    START = {"current_limit": 2.0, "voltage_limit": 24.0, "temperature_limit": 393.15, "damping_resistance": 10.0,
             "damping_capacitance": 1e-3, "back_emf_resistance": 1.5}

    def __init__(self, profile, p):
        self.p, self.profile = p, profile
        self.random = random.Random(p.seed)
        self.motor = Motor(p)
        self.registers = {e["name"]: Number(e, profile["order"], "holding") for e in profile["registers"]}
        capture = profile["capture"]
        self.windows = {k: Number(e, profile["order"], "input") for k, e in capture["signals"].items()}
        self.page_samples = capture.get("page", {}).get("samples", capture["max_samples"])
        self.stores = {table: {} for table in ("coil", "discrete", "input", "holding")}
        self.readable = {table: set() for table in self.stores}
        self.writable = {table: set() for table in self.stores}
        for r in self.registers.values():
            span = range(r.address, r.address + r.words)
            for address in span:
                self.stores[r.table].setdefault(address, 0)
            if r.readable:
                self.readable[r.table].update(span)
            if r.writable:
                self.writable[r.table].update(span)
        for w in self.windows.values():
            span = range(w.address, w.address + w.words * self.page_samples)
            self.readable[w.table].update(span)
            for address in span:
                self.stores[w.table][address] = 0
        for name, value in self.START.items():
            self.put(name, value)
        for check in profile["identity"]:
            self.put(check["register"], check["value"])
        if "drive_mode" in self.registers:
            self.put("drive_mode", self.registers["drive_mode"].codes["current"])
        for name in (profile["excitation"]["kind"],):
            self.put(name, self.registers[name].codes["dc"])
        for name, value in (("capture_samples", 1), ("capture_decimation", 1)):
            if capture[name.split("_")[1]] in self.registers:
                self.put(capture[name.split("_")[1]], value)
        self.state_names = self.registers[capture["state"]].codes
        self.idle = next(iter(sorted(self.state_names, key=self.state_names.get)))
        self.put(capture["state"], self.state_names[self.idle])
        self.kept, self.armed, self.busy = {}, False, False
        self.began = None  # device time at which the excitation began
        self.now = 0.0
        self.ahead = -time.monotonic()
        self.fed = time.monotonic()
        self.faults = 0

    def reset(self):
        pass

    # Values by name, in SI units.
    def words(self, number):
        return [self.stores[number.table][number.address + i] for i in range(number.words)]

    def get(self, name):
        return self.registers[name].decode(self.words(self.registers[name]))

    def put(self, name, value):
        r = self.registers[name]
        for i, word in enumerate(r.encode(value, self.words(r))):
            self.stores[r.table][r.address + i] = word

    def mode(self):
        r = self.registers.get("drive_mode")
        if r is None:
            return "current"
        return {code: name for name, code in r.codes.items()}.get(round(self.get("drive_mode")), "current")

    def generator(self):
        names = self.profile["excitation"]
        g = {key: self.get(names[key]) if names.get(key) else 0
             for key in ("amplitude", "offset", "frequency", "end_frequency", "duration")}
        kinds = {code: name for name, code in self.registers[names["kind"]].codes.items()}
        g["kind"] = kinds[round(self.get(names["kind"]))]
        return g

    # Time.
    def follow_the_clock(self):
        if self.get("enable") and "watchdog" in self.profile and not self.p.no_watchdog:
            if time.monotonic() - self.fed > self.profile["watchdog"]["period"]:
                self.trip("watchdog")
        target = min(time.monotonic() + self.ahead, self.now + 3)
        if self.began is not None and self.armed:
            return  # the capture is computed when it is asked for
        self.run_until(target)

    def run_until(self, target, keep=None):
        ticks = int((target - self.now) / TICK)
        if ticks <= 0:
            return
        settings = {name: self.get(name) if name in self.registers else value for name, value in self.SETTINGS.items()}
        g = self.generator() if self.began is not None else None
        limit = {"current": self.get("current_limit"), "voltage": self.get("voltage_limit")}
        for k in range(ticks):
            enabled = self.get("enable") != 0 if k == 0 or self.faults else enabled
            mode = self.mode() if k == 0 else mode
            command = 0.0
            if g is not None and enabled:
                command = command_at(self.now - self.began, g)
                command = min(max(command, -limit[mode]), limit[mode])
            if keep is not None:
                keep(self.now - self.began, command)
            if not enabled and g is None and self.motor.speed == 0 and abs(self.motor.current) < 1e-9:
                self.now = target
                return
            self.motor.tick(command, enabled, mode, settings)
            self.now += TICK
            if enabled and abs(self.motor.current) > 1.25 * limit["current"]:
                self.trip("overcurrent")
            if enabled and 298.15 + self.motor.rise > self.get("temperature_limit"):
                self.trip("overtemperature")

    def trip(self, name):
        for bit, meaning in self.profile["fault"]["bits"].items():
            if meaning == name:
                self.faults |= 1 << int(bit)
        self.put("enable", 0)
        self.began = None

    def noisy(self, value, sigma):
        return value + self.random.gauss(0, sigma) if sigma else value

    def compute_capture(self):
        names = self.profile["capture"]
        every = round(self.get(names["decimation"])) if "decimation" in names else 1
        start = self.get(names["delay"]) if "delay" in names else 0
        samples = round(self.get(names["samples"]))
        begin, self.kept = self.began, {signal: [] for signal in self.windows}
        first = round(start / TICK)

        def keep(t, command):
            k = round(t / TICK)
            if k < first or (k - first) % every or len(self.kept["command"]) >= samples:
                return
            m, p = self.motor, self.p
            values = {"command": command, "current": self.noisy(m.current, p.noise_current),
                      "voltage": self.noisy(m.terminal, p.noise_voltage),
                      "velocity": self.noisy(m.speed, p.noise_velocity), "position": m.angle}
            for signal in self.kept:
                self.kept[signal].append(values[signal])

        before = self.now
        self.run_until(begin + start + samples * every * TICK + TICK / 2, keep)
        self.ahead += self.now - before
        self.armed = False
        self.put(names["state"], self.state_names["done"])
        self.fed = time.monotonic()
        self.show_page(0)

    def show_page(self, page):
        for signal, w in self.windows.items():
            values = self.kept.get(signal, [])[page * self.page_samples:(page + 1) * self.page_samples]
            for i, value in enumerate(values):
                for j, word in enumerate(w.encode(value)):
                    self.stores[w.table][w.address + i * w.words + j] = word

    def show_actual(self):
        m, p = self.motor, self.p
        for name, value in (("current", self.noisy(m.current, p.noise_current)), ("voltage", m.terminal),
                            ("velocity", self.noisy(m.speed, p.noise_velocity)), ("position", m.angle),
                            ("winding_temperature", 298.15 + m.rise)):
            if name in self.registers:
                self.put(name, value)
        self.put(self.profile["fault"]["register"], self.faults)

    # What pymodbus asks.
    TABLES = {1: "coil", 2: "discrete", 3: "holding", 4: "input", 5: "coil", 6: "holding", 15: "coil", 16: "holding",
              22: "holding", 23: "holding"}

    def validate(self, fx, address, count=1):
        table = self.TABLES[fx]
        allowed = self.writable[table] if fx in (5, 6, 15, 16) else self.readable[table]
        return all(a in allowed for a in range(address, address + count))

    def getValues(self, fx, address, count=1):
        time.sleep(self.p.turnaround)
        table = self.TABLES[fx]
        state = self.registers[self.profile["capture"]["state"]]
        if table == state.table and address <= state.address < address + count and self.armed and self.began is not None:
            self.compute_capture()
        self.follow_the_clock()
        self.show_actual()
        return [self.stores[table][address + i] for i in range(count)]

    def setValues(self, fx, address, values):
        time.sleep(self.p.turnaround)
        table = self.TABLES[fx]
        self.follow_the_clock()
        words = [int(v) for v in values]
        touched = [r for r in self.registers.values()
                   if r.table == table and r.writable and address <= r.address < address + len(words)]
        old = dict(self.stores[table])
        for i, word in enumerate(words):
            self.stores[table][address + i] = word
        for r in touched:
            value = self.get(r.name)
            slack = 1e-9 * max(1.0, abs(value))
            wrong = (r.low is not None and value < r.low - slack) or (r.high is not None and value > r.high + slack)
            if r.codes and round(value) not in r.codes.values():
                wrong = True
            if wrong:
                self.stores[table] = old
                raise ValueError(f"{r.name} = {value}")
        if self.p.log:
            with open(self.p.log, "a", encoding="utf-8") as log:
                for r in touched:
                    log.write(json.dumps({"register": r.name, "value": self.get(r.name)}) + "\n")
        if self.p.stuck in [r.name for r in touched]:
            self.stores[table] = old
            return
        for r in touched:
            self.act(r.name)

    def is_action(self, action, name):
        return action["register"] == name and self.get(name) == self.registers[name].codes.get(
            action.get("value", 1), action.get("value", 1))

    def act(self, name):
        profile = self.profile
        if name == "enable":
            if self.get("enable") and self.faults:
                self.put("enable", 0)
            if not self.get("enable"):
                self.began = None
            self.fed = time.monotonic()
        if self.is_action(profile["fault"]["clear"], name):
            self.faults = 0
        if "watchdog" in profile and profile["watchdog"]["register"] == name:
            self.fed = time.monotonic()
        if self.is_action(profile["excitation"]["stop"], name):
            self.began = None
        if self.is_action(profile["excitation"]["start"], name) and self.get("enable"):
            self.began = self.now
        if self.is_action(profile["capture"]["arm"], name):
            self.armed = True
            self.put(profile["capture"]["state"], self.state_names.get("armed", self.state_names[self.idle]))
        if name == profile["capture"].get("page", {}).get("register"):
            self.show_page(round(self.get(name)))


def read_arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("profile")
    parser.add_argument("--rtu", help="serve RTU on a pseudo-terminal that appears under this name")
    parser.add_argument("--unit", type=int)
    parser.add_argument("--log", help="append every write as a line of JSON")
    parser.add_argument("--stuck", help="a register that ignores what is written to it")
    parser.add_argument("--start", action="append", default=[], help="NAME=VALUE that a register has at first")
    parser.add_argument("--no-watchdog", action="store_true")
    parser.add_argument("--turnaround", type=float, default=0.0, help="before each answer [s]")
    for name, value in (("resistance", 1.5), ("inductance", 0.5e-3), ("torque_constant", 0.05), ("inertia", 2e-5),
                        ("damping", 1e-5), ("coulomb_friction", 1e-3), ("bandwidth", 1000.0), ("delay", 0.0),
                        ("winding_rise", 0.0), ("thermal_resistance", 8.0), ("thermal_capacity", 30.0),
                        ("noise_current", 0.0), ("noise_voltage", 0.0), ("noise_velocity", 0.0)):
        parser.add_argument("--" + name.replace("_", "-"), type=float, default=value)
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


def end_with_stdin(children):
    sys.stdin.read()
    for child in children:
        child.kill()
    os._exit(0)


async def main():
    logging.disable(logging.CRITICAL)
    p = read_arguments()
    with open(p.profile, encoding="utf-8") as file:
        profile = json.load(file)
    profile.setdefault("order", "ABCD")
    if "watchdog" in profile:
        number, unit = profile["watchdog"]["period"].split()
        profile["watchdog"]["period"] = float(number) * unit_factor(unit)
    amplifier = Amplifier(profile, p)
    for text in p.start:
        name, value = text.split("=")
        amplifier.put(name, float(value))
    unit = p.unit or profile["link"].get("unit", 1)
    context = ModbusServerContext(slaves={unit: amplifier}, single=False)
    children = []
    if p.rtu:
        near = p.rtu + ".device"
        children.append(subprocess.Popen(["socat", f"pty,raw,echo=0,link={p.rtu}", f"pty,raw,echo=0,link={near}"],
                                         stdin=subprocess.DEVNULL))
        while not (os.path.exists(p.rtu) and os.path.exists(near)):
            await asyncio.sleep(0.01)
        server = ModbusSerialServer(context, ModbusRtuFramer, port=near, baudrate=115200, timeout=0.001,
                                    ignore_missing_slaves=True)
        await server.start()
        print("device", p.rtu, flush=True)
    else:
        server = ModbusTcpServer(context, ModbusSocketFramer, address=("127.0.0.1", 0), allow_reuse_address=True)
        task = asyncio.ensure_future(server.serve_forever())
        await server.serving
        print("port", server.server.sockets[0].getsockname()[1], flush=True)
    threading.Thread(target=end_with_stdin, args=(children,), daemon=True).start()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    await (server.serve_forever() if p.rtu else task)


if __name__ == "__main__":
    asyncio.run(main())
