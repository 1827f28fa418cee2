"""Our Modbus server spoken to by mbpoll and pymodbus, our link to pymodbus' server, over TCP and serial lines; and
our link over a line that is disturbed."""
import json
import subprocess
import sys
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import modbus_peers as peers
from fault_proxy import FaultProxy
from program import ProgramTest


class MbpollTest(ProgramTest):

    def mbpoll(self, *words):
        done = subprocess.run(["mbpoll", "-0", "-1", "-q", *map(str, words)], capture_output=True, text=True,
                              timeout=peers.PATIENCE_S)
        return done.stdout + done.stderr

    def check(self, *device):
        target, options = device[-1], device[:-1]
        values = self.mbpoll(*options, "-t", 3, "-r", 5, "-c", 3, target)
        self.assertRegex(values, r"\[5\]:\s+36\n\[6\]:\s+43\n\[7\]:\s+50")
        bits = self.mbpoll(*options, "-t", 1, "-r", 0, "-c", 4, target)
        self.assertRegex(bits, r"\[0\]:\s+1\n\[1\]:\s+0\n\[2\]:\s+0\n\[3\]:\s+1")
        for write, table, read in ((("-t", 4, "-r", 20, target, 1234), 4, r"\[20\]:\s+1234"),
                                   (("-t", 4, "-r", 21, target, 5, 6, 7), 4, r"\[21\]:\s+5\n\[22\]:\s+6\n\[23\]:\s+7"),
                                   (("-t", 0, "-r", 20, target, 1), 0, r"\[20\]:\s+1"),
                                   (("-t", 0, "-r", 21, target, 0, 1, 1), 0, r"\[21\]:\s+0\n\[22\]:\s+1\n\[23\]:\s+1")):
            self.assertIn("Written", self.mbpoll(*options, *write))
            self.assertRegex(self.mbpoll(*options, "-t", table, "-r", write[3], "-c", 3, target), read)
        float_order = self.mbpoll(*options, "-t", "4:float", "-B", "-r", 40, target, "3.25")
        self.assertIn("Written", float_order)
        self.assertRegex(self.mbpoll(*options, "-t", "4:hex", "-r", 40, "-c", 2, target),
                         r"0x4050\n\[41\]:\s+0x0000")
        self.assertIn("Illegal data address", self.mbpoll(*options, "-t", 4, "-r", 300, target))

    def test_mbpoll_reads_and_writes_over_tcp(self):
        with peers.serve_tcp() as device:
            self.check("-m", "tcp", "-p", device.where, "-a", 1, "127.0.0.1")

    def test_mbpoll_reads_and_writes_over_a_serial_line(self):
        with peers.serve_rtu(self.folder / "tty") as device:
            self.check("-m", "rtu", "-b", 115200, "-P", "none", "-a", 1, device.where)
            self.assertIn("Connection timed out",
                          self.mbpoll("-m", "rtu", "-b", 115200, "-P", "none", "-o", 0.2, "-a", 2, device.where))


class PymodbusClientTest(ProgramTest):

    def check(self, kind, device):
        requests = [
            ["read_input_registers", 5, 3], ["read_discrete_inputs", 0, 8], ["write_register", 20, 1234],
            ["write_registers", 21, [5, 6, 7]], ["read_holding_registers", 20, 4], ["write_coil", 20, True],
            ["write_coils", 21, [False, True, True]], ["read_coils", 20, 8], ["read_holding_registers", 300, 1],
            ["read_input_registers", 0, 125]]
        done = subprocess.run([peers.pymodbus_python(), "-c", peers.PYMODBUS_CLIENT, kind, device.where],
                              input=json.dumps(requests), capture_output=True, text=True, timeout=peers.PATIENCE_S)
        self.assertEqual(done.returncode, 0, done.stderr)
        answers = json.loads(done.stdout)
        self.assertEqual(answers[0], [36, 43, 50])
        self.assertEqual(answers[1], [1, 0, 0, 1, 0, 0, 1, 0])
        self.assertEqual(answers[4], [1234, 5, 6, 7])
        self.assertEqual(answers[7], [1, 0, 1, 1, 0, 0, 0, 0])
        self.assertIn("IllegalAddress", answers[8])
        self.assertEqual(answers[9], [7 * i + 1 for i in range(125)])
        self.assertEqual([answers[i] for i in (2, 3, 5, 6)], [None] * 4)

    def test_pymodbus_reads_and_writes_over_tcp(self):
        with peers.serve_tcp() as device:
            self.check("tcp", device)

    def test_pymodbus_reads_and_writes_over_a_serial_line(self):
        with peers.serve_rtu(self.folder / "tty") as device:
            self.check("rtu", device)


class PymodbusServerTest(ProgramTest):

    def check(self, link):
        for line, answer in (("input 5 3", "ok 36 43 50"), ("discrete 0 4", "ok 1 0 0 1"),
                             ("write 20 1234", "ok"), ("write 21 5 6 7", "ok"), ("holding 20 4", "ok 1234 5 6 7"),
                             ("set 20 1", "ok"), ("sets 21 0 1 1", "ok"), ("coil 20 4", "ok 1 0 1 1"),
                             ("input 0 190", "ok " + " ".join(str(7 * i + 1) for i in range(190)))):
            self.assertEqual(link.ask(line), answer)
        self.assertRegex(link.ask("holding 300 1"), r"exception .*holding 0x012C \(40301\).*illegal data address \(2\)")
        self.assertEqual(link.ask("statistics"), "ok 11 4 0 0")

    def test_our_link_speaks_to_pymodbus_over_tcp(self):
        with peers.pymodbus_server("tcp") as device, peers.Link(f"tcp://127.0.0.1:{device.where}", 5) as link:
            self.check(link)

    def test_our_link_speaks_to_pymodbus_over_a_serial_line(self):
        with peers.terminal_pair(self.folder) as (near, far), peers.pymodbus_server("rtu", far):
            with peers.Link(f"rtu://{near}?baud=115200", 5) as link:
                self.check(link)


class DisturbedLineTest(ProgramTest):

    def disturbed(self, **how):
        """A device, the proxy before it, and a link through the proxy."""
        device = self.enterContext(peers.serve_tcp())
        proxy = self.enterContext(FaultProxy(("127.0.0.1", int(device.where)), **how))
        link = self.enterContext(peers.Link(f"tcp://127.0.0.1:{proxy.port}", 0.15, 6))
        return device, proxy, link

    def enterContext(self, manager):  # of unittest itself from Python 3.11 on
        value = manager.__enter__()
        self.addCleanup(manager.__exit__, None, None, None)
        return value

    def test_each_fault_of_an_answer_is_named_and_no_write_repeated(self):
        named = {"drop": "timeout", "half": "timeout", "cut": "lost", "corrupt": "garbled|timeout|exception|lost",
                 "garbage": "garbled|timeout|lost"}
        device, proxy, link = self.disturbed(seed=3)
        writes = 0
        for kind, fault in named.items():
            for _ in range(4):
                proxy.plan.append(("answer", kind))
                with self.subTest(kind=kind):
                    self.assertRegex(link.ask("write 3 7"), f"^({fault}) ")
                writes += 1
                self.assertEqual(link.ask("input 2 2"), "ok 15 22")
        self.assertEqual([f.kind for f in proxy.faults], [kind for kind in named for _ in range(4)])
        self.assertEqual(device.finish().split()[3], str(writes))

    def test_faults_on_the_way_there_leave_the_write_undone(self):
        device, proxy, link = self.disturbed(seed=4)
        for kind in ("drop", "cut", "half"):
            proxy.plan.append(("request", kind))
            with self.subTest(kind=kind):
                self.assertRegex(link.ask("write 3 7"), "^(timeout|lost) .*read it back")
            self.assertEqual(link.ask("holding 3 1"), "ok 0")
        self.assertEqual(device.finish().split()[3], "0")

    def test_random_faults_never_give_a_wrong_value_nor_a_second_write(self):
        kinds = {"drop": 0.03, "delay": 0.05, "cut": 0.03, "cut_after": 0.03, "duplicate": 0.05, "half": 0.02,
                 "garbage": 0.02}
        device, proxy, link = self.disturbed(seed=2026, rates=kinds, delay=(0.05, 0.25))
        sent, held, on_its_way = 0, 0, []  # the last: values of writes that were given up, with their time
        for i in range(80):
            answer = link.ask(f"input {i} 3")
            if answer.startswith("ok"):
                self.assertEqual(answer, "ok " + " ".join(str(7 * (i + k) + 1) for k in range(3)))
            sent += 1
            if link.ask(f"write 9 {sent}").startswith("ok"):
                held = sent
            else:
                on_its_way.append((sent, time.monotonic()))
            back = link.ask("holding 9 1")
            if back.startswith("ok"):
                # The proxy holds a frame back for at most 0.25 s; a busy machine adds to it.
                late = {value for value, since in on_its_way if time.monotonic() - since < 2}
                self.assertIn(int(back.split()[1]), {held} | late)
                held = int(back.split()[1])
        seen = {fault.kind for fault in proxy.faults}
        self.assertEqual(seen, set(kinds))
        # A duplicated request writes twice: what the proxy does, no client can undo.
        repeated = sum(f.kind == "duplicate" and f.direction == "request" for f in proxy.faults)
        self.assertLessEqual(int(device.finish().split()[3]), sent + repeated)


class ProxyTest(unittest.TestCase):

    def test_kinds_that_are_none_are_refused(self):
        with self.assertRaisesRegex(ValueError, "allowed: drop"):
            FaultProxy(("127.0.0.1", 1), rates={"dorp": 1})


if __name__ == "__main__":
    unittest.main()
