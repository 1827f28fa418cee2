"""gyrator twin as others see it: mbpoll and pymodbus over TCP and a terminal, its moods, and what it refuses."""
import json
import re
import signal
import socket
import struct
import subprocess
import sys
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import modbus_peers as peers
from program import EXAMPLES, PATIENCE_S, RC_DISPLAY, ProgramTest, load_example, program, with_value, without

# Addresses of profiles/gyrator_twin.json.
ENABLE, CONNECTED, RUN, ARM = 0, 1, 3, 4
CURRENT_LIMIT, DAMPING_RESISTANCE = 16, 26
STATE, TIME = 11, 12
DONE = 3


class Twin:
    """A twin that runs beside a test; `where` is "tcp://…" or "rtu://…" of each line that it serves."""

    def __init__(self, *options, model=RC_DISPLAY, folder=None, lines=1):
        words = [program(), "twin", str(model), *map(str, options)]
        self.process = subprocess.Popen(words, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True)
        self.where = [self.process.stdout.readline().strip().removeprefix("listening on ") for _ in range(lines)]
        if not all(self.where):
            raise RuntimeError(f"no address: {self.process.communicate(timeout=PATIENCE_S)[1]}")

    @property
    def port(self):
        return int(self.where[0].rsplit(":", 1)[1])

    def stop(self, by=signal.SIGINT):
        """Exit code, and what it says at its end."""
        self.process.send_signal(by)
        out, err = self.process.communicate(timeout=PATIENCE_S)
        assert out == "", out
        return self.process.returncode, err

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()


class Client:
    """The least that speaks Modbus TCP: answers as they come, exceptions as negative numbers."""

    def __init__(self, twin, timeout=PATIENCE_S):
        self.socket = socket.create_connection(("127.0.0.1", twin.port), timeout=timeout)
        self.number = 0

    def close(self):
        self.socket.close()

    def receive(self, count):
        data = b""
        while len(data) < count:
            more = self.socket.recv(count - len(data))
            if not more:
                raise ConnectionError("closed")
            data += more
        return data

    def request(self, pdu):
        self.number += 1
        self.socket.sendall(struct.pack(">HHHB", self.number, 0, len(pdu) + 1, 1) + pdu)
        number, _, length, _ = struct.unpack(">HHHB", self.receive(7))
        answer = self.receive(length - 1)
        if number != self.number:
            raise ValueError("another number")
        return answer

    def ask(self, pdu):
        answer = self.request(pdu)
        return -answer[1] if answer[0] & 0x80 else answer

    def read(self, function, address, count):
        answer = self.ask(struct.pack(">BHH", function, address, count))
        if isinstance(answer, int):
            return answer
        return list(struct.unpack(f">{count}H", answer[2:])) if function > 2 else answer[2] & 1

    def read_float(self, address, function=3, form="f"):
        words = self.read(function, address, struct.calcsize(form) // 2)
        return struct.unpack(">" + form, struct.pack(f">{len(words)}H", *words))[0]

    def write(self, address, form, value):
        data = struct.pack(">" + form, value)
        head = struct.pack(">BHHB", 16, address, len(data) // 2, len(data))
        answer = self.ask(head + data)
        return answer if isinstance(answer, int) else 0

    def switch(self, address, on=True):
        answer = self.ask(struct.pack(">BHH", 5, address, 0xFF00 if on else 0))
        return answer if isinstance(answer, int) else 0


class TwinTest(ProgramTest):

    def twin(self, *options, **more):
        twin = Twin(*options, folder=self.folder, **more)
        self.addCleanup(twin.__exit__)
        return twin

    def fast(self, *options, **more):
        return self.twin("--listen", "127.0.0.1:0", "--time-scale", "max", *options, **more)

    def client(self, twin, **more):
        client = Client(twin, **more)
        self.addCleanup(client.close)
        return client


class PeersTest(TwinTest):

    def mbpoll(self, *words):
        done = subprocess.run(["mbpoll", "-0", "-1", "-q", *map(str, words)], capture_output=True, text=True,
                              timeout=PATIENCE_S)
        return done.stdout + done.stderr

    def check_mbpoll(self, *device):
        target, options = device[-1], device[:-1]
        self.assertRegex(self.mbpoll(*options, "-t", 4, "-r", 0, target), r"\[0\]:\s+26489")
        self.assertIn("Written", self.mbpoll(*options, "-t", "4:float", "-B", "-r", DAMPING_RESISTANCE, target, 7.5))
        self.assertRegex(self.mbpoll(*options, "-t", "4:float", "-B", "-r", DAMPING_RESISTANCE, target), r"7\.5")
        self.assertIn("Written", self.mbpoll(*options, "-t", 0, "-r", CONNECTED, target, 0))
        self.assertRegex(self.mbpoll(*options, "-t", 0, "-r", ENABLE, "-c", 2, target), r"\[0\]:\s+0\n\[1\]:\s+0")
        self.assertIn("Written", self.mbpoll(*options, "-t", 0, "-r", ENABLE, target, 1, 1))
        self.assertRegex(self.mbpoll(*options, "-t", 0, "-r", ENABLE, "-c", 2, target), r"\[0\]:\s+1\n\[1\]:\s+1")
        self.assertRegex(self.mbpoll(*options, "-t", "3:float", "-B", "-r", 8, target), r"298\.1")
        self.assertIn("Illegal data address", self.mbpoll(*options, "-t", 4, "-r", 500, target))
        self.assertIn("Illegal data value",
                      self.mbpoll(*options, "-t", "4:float", "-B", "-r", DAMPING_RESISTANCE, target, 1000))

    def test_mbpoll_over_tcp(self):
        self.check_mbpoll("-m", "tcp", "-p", self.fast().port, "-a", 1, "127.0.0.1")

    def test_mbpoll_over_a_terminal(self):
        twin = self.twin("--rtu", "tty", "--time-scale", "max")
        self.assertTrue(twin.where[0].startswith("rtu://"), twin.where)
        self.check_mbpoll("-m", "rtu", "-b", 115200, "-P", "even", "-a", 1, self.folder / "tty")
        code, _ = twin.stop()
        self.assertEqual(code, 0)
        self.assertFalse((self.folder / "tty").is_symlink(), "left behind")

    def check_pymodbus(self, kind, where):
        requests = [
            ["read_holding_registers", 0, 1],
            ["write_registers", CURRENT_LIMIT, list(struct.unpack(">2H", struct.pack(">f", 0.75)))],
            ["read_holding_registers", CURRENT_LIMIT, 2],
            ["write_coil", CONNECTED, True], ["write_coils", ENABLE, [True, False]], ["read_coils", ENABLE, 2],
            ["read_input_registers", TIME, 4],
            ["write_register", CURRENT_LIMIT, 1],
            ["read_discrete_inputs", 0, 1]]
        done = subprocess.run([peers.pymodbus_python(), "-c", peers.PYMODBUS_CLIENT, kind, str(where)],
                              input=json.dumps(requests), capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual(done.returncode, 0, done.stderr)
        answers = json.loads(done.stdout)
        self.assertEqual(answers[:1] + answers[2:3], [[26489], [0x3F40, 0]])
        self.assertEqual(answers[1], None)
        self.assertEqual(answers[3:5], [None, None])
        self.assertEqual(answers[5][:2], [1, 0])
        self.assertEqual(len(answers[6]), 4)
        self.assertIn("IllegalValue", answers[7])  # half a number
        self.assertIn("IllegalAddress", answers[8])

    def test_pymodbus_over_tcp(self):
        self.check_pymodbus("tcp", self.fast().port)

    def test_pymodbus_over_a_terminal(self):
        self.twin("--rtu", "tty", "--time-scale", "max")
        self.check_pymodbus("rtu", self.folder / "tty")

    def test_two_clients_and_a_terminal_at_once(self):
        twin = self.twin("--listen", "127.0.0.1:0", "--rtu", "tty", "--time-scale", "max", lines=2)
        one, other = self.client(twin), self.client(twin)
        for ohm in (3, 4.5, 20):
            self.assertEqual(one.write(DAMPING_RESISTANCE, "f", ohm), 0)
            self.assertEqual(other.read_float(DAMPING_RESISTANCE), ohm)
        self.assertRegex(self.mbpoll("-m", "rtu", "-b", 115200, "-P", "even", "-a", 1, "-t", "4:float", "-B", "-r",
                                     DAMPING_RESISTANCE, self.folder / "tty"), r"\s20")

    def test_the_second_profile_answers_in_its_own_way(self):
        twin = self.fast("--profile", "integer_drive", "--unit", 1)
        client = self.client(twin)
        self.assertEqual(client.read(3, 100, 1), [19761])
        self.assertEqual(client.write(212, "H", 13), 0)  # 13 half ohms above 1 ohm
        self.assertEqual(client.read(3, 212, 1), [13])
        self.assertEqual(client.write(210, "I", 500 << 16), 0)  # 500 mohm, the low word first
        self.assertEqual(client.read(3, 210, 2), [500, 0])


class TimeTest(TwinTest):

    def experiment(self, client):
        """A sine of 0.2 A at 40 Hz; current and velocity of its second quarter second, as words."""
        for address, form, value in ((48, "H", 2), (50, "f", 0.2), (52, "f", 0), (54, "f", 40), (58, "f", 0.5),
                                     (64, "f", 0.25), (66, "H", 5), (67, "H", 500)):
            self.assertEqual(client.write(address, form, value), 0, address)
        for coil in (ENABLE, ARM, RUN):
            self.assertEqual(client.switch(coil), 0)
        self.assertEqual(client.read(4, STATE, 1), [DONE])  # the state, while busy, jumps to the end
        words = []
        for base in (9000, 25000):
            for at in range(base, base + 1000, 100):
                words += client.read(4, at, 100)
        self.assertEqual(client.switch(ENABLE, False), 0)
        return words

    def test_at_max_the_same_requests_give_the_same_answers(self):
        first = self.experiment(self.client(self.fast("--seed", 5)))
        self.assertEqual(self.experiment(self.client(self.fast("--seed", 5))), first)
        self.assertNotEqual(self.experiment(self.client(self.fast("--seed", 6))), first)
        current = struct.unpack(">500f", struct.pack(">1000H", *first[:1000]))
        self.assertGreater(max(current), 0.05)
        self.assertLess(max(current), 0.25)

    def test_at_max_time_passes_with_requests_only(self):
        client = self.client(self.fast("--turnaround", "5 ms"))
        before = client.read_float(TIME, 4, "d")
        time.sleep(0.2)
        # One request, not the time that the wall clock went on.
        self.assertAlmostEqual(client.read_float(TIME, 4, "d") - before, 5e-3, delta=1e-9)
        client.write(72, "d", 100.0)
        self.assertGreater(client.read_float(TIME, 4, "d"), before + 100)

    def test_in_real_time_the_clock_is_the_walls(self):
        client = self.client(self.twin("--listen", "127.0.0.1:0"))
        wall, before = time.monotonic(), client.read_float(TIME, 4, "d")
        time.sleep(0.5)
        passed = client.read_float(TIME, 4, "d") - before
        self.assertAlmostEqual(passed, time.monotonic() - wall, delta=0.2)
        self.assertGreater(passed, 0.45)

    def test_a_drive_that_nobody_feeds_switches_itself_off(self):
        client = self.client(self.twin("--listen", "127.0.0.1:0"))
        client.switch(ENABLE)
        self.assertEqual(client.read(1, ENABLE, 1), 1)
        time.sleep(0.8)  # the profile's watchdog has 0.5 s
        self.assertEqual(client.read(1, ENABLE, 1), 0)
        self.assertEqual(client.read(4, 10, 1), [1 << 3])
        self.assertEqual(client.switch(ENABLE), -4)

    def test_bytes_take_their_time_on_a_slow_line(self):
        client = self.client(self.twin("--listen", "127.0.0.1:0", "--baud", 1200))
        began = time.monotonic()
        client.read(4, 0, 14)
        # 8 + 33 characters, nearly, at 11 bits: less by what TCP's head differs from RTU's frame.
        self.assertGreater(time.monotonic() - began, 0.9 * 41 * 11 / 1200)


class MoodsTest(TwinTest):

    def test_busy_is_answered_and_nothing_done(self):
        client = self.client(self.fast("--misbehave", "busy=1"))
        self.assertEqual(client.read(3, 0, 1), -6)
        self.assertEqual(client.write(DAMPING_RESISTANCE, "f", 30), -6)

    def test_late_answers_come_late(self):
        client = self.client(self.fast("--misbehave", "late=1:0.3s"))
        began = time.monotonic()
        self.assertEqual(client.read(3, 0, 1), [26489])
        self.assertGreater(time.monotonic() - began, 0.29)

    def test_dropped_connections_close_and_others_stay(self):
        twin = self.fast("--misbehave", "drop=1")
        for _ in range(2):
            with self.assertRaises(ConnectionError):
                self.client(twin).read(3, 0, 1)

    def test_a_wrong_echo_names_another_address(self):
        client = self.client(self.fast("--misbehave", "echo=1"))
        answer = client.request(struct.pack(">BHH", 5, CONNECTED, 0xFF00))
        self.assertEqual(answer, struct.pack(">BHH", 5, CONNECTED ^ 1, 0xFF00))

    def test_a_stuck_register_keeps_its_value(self):
        client = self.client(self.fast("--misbehave", "stuck=damping_resistance"))
        before = client.read_float(DAMPING_RESISTANCE)
        self.assertEqual(client.write(DAMPING_RESISTANCE, "f", before + 10), 0)
        self.assertEqual(client.read_float(DAMPING_RESISTANCE), before)

    def test_silence_and_garbage(self):
        with self.assertRaises(TimeoutError):
            self.client(self.fast("--misbehave", "silent=1"), timeout=0.3).read(3, 0, 1)
        with self.assertRaises(ValueError):
            self.client(self.fast("--misbehave", "garble=1")).read(3, 0, 1)
        with self.assertRaises(TimeoutError):
            self.client(self.fast("--misbehave", "half=1"), timeout=0.3).read(3, 0, 1)


class ProgramEndsTest(TwinTest):

    def test_ctrl_c_and_sigterm_end_it_cleanly(self):
        for by in (signal.SIGINT, signal.SIGTERM):
            twin = self.fast()
            self.client(twin).read(3, 0, 1)
            code, err = twin.stop(by)
            self.assertEqual(code, 0, err)
            self.assertIn("1 requests, 0 of them refused; faults: none", err)

    def test_quiet_prints_the_address_only(self):
        twin = self.fast("--quiet")
        self.assertTrue(re.fullmatch(r"tcp://127\.0\.0\.1:\d+", twin.where[0]), twin.where)
        self.assertEqual(twin.stop(), (0, ""))

    def test_models_that_are_no_amplifier_with_a_motor_are_refused(self):
        ideal = self.write_model(with_value(load_example(), "/amplifier", {"kind": "ideal"}))
        self.assert_refused(self.run_program("twin", ideal, "--listen", "127.0.0.1:0"),
                            f"{ideal}: /amplifier: ideal", '"kind": "voltage"')
        bare = without(without(load_example(), "/motor"), "/damping")
        bare = self.write_model(with_value(bare, "/amplifier", {"kind": "ideal"}))
        self.assert_refused(self.run_program("twin", bare), "/amplifier", "motor")
        self.assert_refused(self.run_program("twin", EXAMPLES / "wave_display.json"), "/damping/", "wave")
        self.assert_refused(self.run_program("twin", "nowhere.json"), "nowhere.json")

    def test_bad_options_are_named(self):
        for words, fragments in (
                (["--profile", "gyrator_twn"], ["gyrator_twn"]),
                (["--time-scale", "fast"], ["--time-scale"]),
                (["--time-scale", "0"], ["--time-scale", "real, max"]),
                (["--listen", "127.0.0.1:99999"], ["--listen"]),
                (["--listen", "rtu:///dev/null"], ["--listen"]),
                (["--unit", "248"], ["--unit"]),
                (["--current-noise", "1 V"], ["--current-noise"]),
                (["--winding-rise", "-400"], ["winding rise"]),
                (["--seed", "1.5"], ["--seed"]),
                (["--misbehave", "bussy=1"], ["busy"]),
                (["--misbehave", "stuck=curent_limit"], ["current_limit"])):
            with self.subTest(words):
                self.assert_refused(self.run_program("twin", RC_DISPLAY, "--listen", "127.0.0.1:0", *words)
                                    if words[0] != "--listen" else self.run_program("twin", RC_DISPLAY, *words),
                                    *fragments)

    def test_other_machines_are_not_listened_to_unless_asked_for(self):
        self.assert_refused(self.run_program("twin", RC_DISPLAY, "--listen", "0.0.0.0:0"), "0.0.0.0")
        twin = self.twin("--listen", "0.0.0.0:0", "--allow-remote")
        self.assertEqual(self.client(twin).read(3, 0, 1), [26489])

    def test_a_port_in_use_is_named(self):
        twin = self.fast()
        self.assert_refused(self.run_program("twin", RC_DISPLAY, "--listen", f"127.0.0.1:{twin.port}"),
                            str(twin.port), code=4)


if __name__ == "__main__":
    unittest.main()
