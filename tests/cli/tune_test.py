"""gyrator tune against the simulated amplifier and against the amplifier of pymodbus; faults and kills on the way.

GYRATOR_SOAK=20 makes the runs with faults and kills so many times longer (1000 faults, 50 kills and more).
"""
import json
import os
import random
import subprocess
import sys
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from fault_proxy import FaultProxy
from peer import PROFILE as INTEGER_PROFILE
from peer import Peer
from program import DeviceTest, load_example, program
from twin_test import DAMPING_RESISTANCE, Client, Twin

SOAK = int(os.environ.get("GYRATOR_SOAK", "1"))
TUNED = {"damping_connected", "damping_resistance", "damping_capacitance", "cancellation_resistance",
         "back_emf_damping", "back_emf_resistance", "drive_mode"}


def motor(stiffness=0.2, thermal=None):
    """What `identify` would have written of the example's motor, with a wall that is wanted."""
    model = load_example()
    model["name"] = "bench motor"
    model["damping"] = []
    model["amplifier"] = {"kind": "current", "bandwidth": "2 kHz"}
    model["controller"].update({"stiffness": stiffness, "damping": 1.5e-4})
    if thermal:
        model["motor"]["thermal"] = thermal
    return model


class TuneTest(DeviceTest):

    def twin(self, *options, model=None):
        (self.folder / "device.json").write_text(json.dumps(model or motor()))
        twin = Twin("--listen", "127.0.0.1:0", "--time-scale", "max", *options, model="device.json",
                    folder=self.folder)
        self.addCleanup(twin.__exit__)
        return twin

    def write_model(self, model, name="motor.json"):
        (self.folder / name).write_text(json.dumps(model))
        return name

    @staticmethod
    def device(url, profile="gyrator_twin"):
        return "--connect", url, "--profile", profile

    def tune(self, model, *arguments, **more):
        return self.run_program("tune", self.write_model(model), *arguments, "--json", **more)

    def changed(self, device, before="before.json"):
        """Names of the registers that are not as they were."""
        answer = self.run_program("diff", before, *device, "--json")
        self.assertIn(answer.code, (0, 1), answer)
        return {row["register"] for row in answer.json["plan"]}


class SuccessTest(TuneTest):

    def test_without_apply_a_plan_is_all(self):
        device = self.device(self.twin().where[0])
        self.run_program("backup", *device, "-o", "before.json")
        answer = self.tune(motor(), *device)
        self.assertEqual(answer.code, 0, answer)
        self.assertEqual((answer.json["outcome"], answer.json["applied"], answer.json["state"]),
                         ("planned", False, "safe"))
        rows = {row["register"]: row for row in answer.json["plan"]}
        self.assertGreater(rows["damping_capacitance"]["new"], 0)
        self.assertEqual(rows["damping_capacitance"]["unit"], "F")
        self.assertTrue(answer.json["reaches_wall"])
        self.assertEqual(self.changed(device), set())

    def test_a_branch_is_set_for_a_wall_and_measured_passive(self):
        device = self.device(self.twin().where[0])
        self.run_program("backup", *device, "-o", "before.json")
        answer = self.tune(motor(), *device, "--apply", "-o", "tuned.json", "--svg", "tuned.svg",
                           "--write-model", "tuned_model.json", "--csv", "tuned.csv")
        self.assertEqual(answer.code, 0, answer)
        result = answer.json
        self.assertEqual((result["outcome"], result["verdict"], result["state"]), ("reached", "passive", "changed"))
        self.assertGreater(result["measured_max_stiffness_low"], 0.2)
        self.assertTrue(all(step["stable"] for step in result["steps"]))
        changed = self.changed(device)
        self.assertIn("damping_capacitance", changed)
        self.assertLessEqual(changed, TUNED)
        self.assertEqual({row["register"] for row in result["plan"]}, changed)
        # What was measured, and what was written, by other commands.
        answer = self.run_program("passivity", "tuned_model.json", "--json")
        self.assertEqual(answer.json["verdict"], "passive")
        exact = next(c for c in answer.json["criteria"] if c["name"] == "exact_disk")
        self.assertAlmostEqual(result["measured_max_stiffness"] / exact["max_stiffness"], 1, delta=0.1)
        self.assertEqual(self.run_program("report", "tuned.json", "-o", "tuned.html").code, 0)
        page = (self.folder / "tuned.html").read_text()
        self.assertIn("Tuning of the amplifier", page)
        self.assertIn("damping_capacitance", page)
        self.assertTrue((self.folder / "tuned.svg").read_text().startswith("<?xml"))
        self.assertEqual(len((self.folder / "tuned.csv").read_text().splitlines()), 11)
        # All of it goes back from the journal.
        answer = self.run_program("restore", "--journal", result["journal"], "--apply")
        self.assertEqual(answer.code, 0, answer)
        self.assertEqual(self.changed(device), set())

    def test_cancelling_does_not_hang_on_the_noise(self):
        # Motion ends within milliseconds here; what is left of the ring-down is the tachometer's noise.
        for seed in range(1, 5):
            device = self.device(self.twin("--winding-rise", "20 K", "--seed", seed).where[0])
            answer = self.tune(motor(), *device, "--apply", "--cancellation", "0.85", "--points", "5")
            self.assertEqual(answer.code, 0, answer)
            self.assertEqual(answer.json["outcome"], "reached")

    def test_a_small_motor_is_spared(self):
        # 0.6 A at 3 Hz would bring it to 1400 rad/s, and a push in voltage mode to three times the current's limit.
        model = motor(0.02)
        model["motor"].update({"torque_constant": "23.5 mN.m/A", "resistance": "2.06 ohm", "inductance": "0.238 mH"})
        model["mechanics"] = {"inertia": 1.07e-6, "damping": 1.2e-6, "coulomb_friction": "0.3 mN.m"}
        model["controller"].update({"damping": 2e-5})
        for more in ([], ["--cancellation", "0.85"]):
            device = self.device(self.twin(model=model).where[0])
            answer = self.tune(model, *device, "--apply", *more)
            self.assertEqual(answer.code, 0, answer)
            self.assertEqual(answer.json["outcome"], "reached", answer)

    def test_a_warming_winding_is_cancelled_to_its_share_without_a_fault(self):
        # A winding of 4 s, 20 K warmer than the model says, that goes on warming.
        model = motor(thermal={"resistance": "8 K/W", "capacity": "0.5 J/K"})
        twin = self.twin("--winding-rise", "20 K", "--ambient", "298.15 K", model=model)
        device = self.device(twin.where[0])
        answer = self.tune(motor(), *device, "--apply", "--cancellation", "0.85", "--watch", "20 s",
                           "--write-model", "tuned_model.json")
        self.assertEqual(answer.code, 0, answer)
        result = answer.json
        self.assertEqual(result["outcome"], "reached")
        self.assertTrue(all(step["stable"] for step in result["steps"]))
        share = result["settings"]["cancellation_resistance"] / result["winding"]["resistance"]
        self.assertAlmostEqual(share, 0.85, delta=0.01)
        for step in result["steps"]:
            self.assertLess(step["settings"]["cancellation_resistance"], 0.86 * step["winding_resistance"])
        # The wall that the written model allows is the one that was measured, by the same gain.
        answer = self.run_program("passivity", "tuned_model.json", "--json")
        exact = next(c for c in answer.json["criteria"] if c["name"] == "exact_disk")
        self.assertAlmostEqual(result["measured_max_stiffness"] / exact["max_stiffness"], 1, delta=0.05)
        left = result["winding"]["resistance"] - result["settings"]["cancellation_resistance"]
        self.assertAlmostEqual(result["command_per_effort"] / (left / 0.05), 1, delta=1e-6)
        followed = {step["settings"]["cancellation_resistance"] for step in result["steps"][4:]}
        self.assertGreater(len(followed), 0)

    def test_an_amplifier_of_another_layout_is_tuned_alike(self):
        peer = Peer("--resistance", 1.5, "--inductance", 0.5e-3, "--torque-constant", 0.05, "--inertia", 2e-5,
                    "--damping", 1e-4, "--coulomb-friction", 1e-4, "--bandwidth", 2000, log=self.folder / "writes.jsonl")
        self.addCleanup(peer.close)
        device = self.device(peer.url, "integer_drive")
        self.run_program("backup", *device, "-o", "before.json")
        # Plain Python integrates a motor slowly.
        answer = self.tune(motor(), *device, "--apply", "--from", "12 Hz", "--points", "5", timeout=200)
        self.assertEqual(answer.code, 0, answer)
        self.assertEqual((answer.json["outcome"], answer.json["verdict"]), ("reached", "passive"))
        self.assertLessEqual(self.changed(device), TUNED)
        check_limits(self, peer)


class RefusalTest(TuneTest):

    def test_a_wall_that_nothing_carries_changes_nothing(self):
        device = self.device(self.twin().where[0])
        self.run_program("backup", *device, "-o", "before.json")
        answer = self.tune(motor(50), *device, "--apply")
        self.assertEqual(answer.code, 1, answer)
        self.assertEqual((answer.json["outcome"], answer.json["state"]), ("unreachable", "safe"))
        self.assertEqual(self.changed(device), set())

    def test_the_model_of_another_motor_is_recognized(self):
        device = self.device(self.twin().where[0])
        self.run_program("backup", *device, "-o", "before.json")
        model = motor()
        model["motor"]["torque_constant"] = 0.1
        answer = self.tune(model, *device, "--apply")
        self.assertEqual(answer.code, 1, answer)
        self.assertIn("torque constant", answer.json["explanation"])
        self.assertEqual(self.changed(device), set())

    def test_settings_that_cannot_be_kept_are_refused_before_the_first_write(self):
        profile = json.loads((INTEGER_PROFILE.parent / "gyrator_twin.json").read_text())
        del profile["persist"]
        (self.folder / "forgetful.json").write_text(json.dumps(profile))
        answer = self.tune(motor(), *self.device(self.twin().where[0], "forgetful.json"), "--apply", "--persist")
        self.assertEqual(answer.code, 2, answer)
        self.assertIn("--persist: gyrator twin: its profile knows no way", answer.err)
        self.assertEqual(list(self.folder.glob("state/gyrator/*.jsonl")), [])

    def test_what_has_changed_behind_its_back_is_not_kept(self):
        twin = self.twin()
        device = self.device(twin.where[0])
        self.run_program("backup", *device, "-o", "before.json")
        process = subprocess.Popen([program(), "tune", self.write_model(motor()), *device, "--apply", "--persist",
                                    "--points", "40"], cwd=self.folder, env=self.environment, text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(process.kill)
        for _ in range(3):  # steps; what follows is the measurement of the whole response
            self.assertIn("damping_resistance", process.stderr.readline())
        client = Client(twin)
        self.addCleanup(client.close)
        resistance = client.read_float(DAMPING_RESISTANCE)
        self.assertEqual(client.write(DAMPING_RESISTANCE, "f", resistance + 0.5), 0)
        out, err = process.communicate(timeout=60)
        self.assertEqual((process.returncode, out), (4, ""), err)
        self.assertIn(f"reads {resistance + 0.5:g} ohm, not the {resistance:g} ohm that was set and measured", err)
        self.assertIn("nothing is kept", err)
        self.assertIn("the device is in its safe state, its settings as they were", err)
        self.assertEqual(self.changed(device), set())

    def test_mistakes_are_named(self):
        for arguments, words in [
                (("--margin", "0.5"), ["--margin", "at least 1"]),
                (("--cancellation", "0.95"), ["--cancellation", "--most-cancellation"]),
                (("--most-cancellation", "1"), ["between 0 and 1"]),
                (("--circuit", "lc"), ["lc"]),
                (("--from", "500 Hz"), ["--from", "must rise"]),
                (("--points", "3"), ["--points", "4 to 100"]),
                (("--watch", "5 s"), ["--watch", "cancel"]),
                (("--limit", "current_limit=50A"), ["tighter, not wider"]),
                (("--limit", "current=1A"), ["only read"]),
                (("--cancellation", "0.5", "--watch", "5 ohm"), ["--watch", "time"])]:
            answer = self.run_program("tune", self.write_model(motor()), *self.device("tcp://127.0.0.1:9"), *arguments)
            self.assertEqual(answer.code, 2, answer)
            for word in words:
                self.assertIn(word, answer.err)
        answer = self.run_program("tune", "motor.json", *self.device("tcp://127.0.0.1:9"))
        self.assertEqual(answer.code, 4, answer)
        model = motor()
        model["controller"] = {"kind": "none"}
        answer = self.run_program("tune", self.write_model(model), *self.device(self.twin().where[0]))
        self.assertEqual(answer.code, 2, answer)


def check_limits(test, peer):
    """Nothing that ever arrived at the device was outside its profile."""
    registers = {r["name"]: r for r in json.loads(INTEGER_PROFILE.read_text())["registers"]}
    writes = peer.writes()
    test.assertGreater(len(writes), 0)
    for write in writes:
        register = registers.get(write["register"])
        if register is None or "min" not in register or not isinstance(write["value"], (int, float)):
            continue
        factor = {"mohm": 1e-3, "uF": 1e-6, "mA": 1e-3, "mV": 1e-3}.get(register.get("unit"), 1)
        test.assertGreaterEqual(write["value"], register["min"] * factor - 1e-9, write)
        test.assertLessEqual(write["value"], register["max"] * factor + 1e-9, write)


class FaultTest(TuneTest):
    """Whatever happens on the line: in the end no register is left changed that was not to be."""

    def put_back(self, device):
        """From every tuning's journal, as a user would after reading what the program said."""
        for path in self.journals("tune"):
            answer = self.run_program("restore", "--journal", path, "--apply", "--connect", device[1])
            self.assertEqual(answer.code, 0, answer)
        for path in self.folder.glob("state/gyrator/*.jsonl"):
            path.unlink()

    def test_random_faults_on_the_line(self):
        twin = self.twin()
        direct = self.device(twin.where[0])
        self.run_program("backup", *direct, "-o", "before.json")
        outcomes, faults, seed = set(), 0, 0
        while faults < 60 * SOAK or (seed < 20 and not {0, 4} <= outcomes):  # both ends are to be seen
            seed += 1
            rates = dict.fromkeys(("drop", "cut", "cut_after", "corrupt", "duplicate", "half", "garbage", "delay"),
                                  0.0005 * (1 + seed % 4))
            with FaultProxy(("127.0.0.1", twin.port), seed=seed, rates=rates, delay=(0.01, 0.1)) as proxy:
                answer = self.run_program("tune", self.write_model(motor()),
                                          *self.device(f"tcp://127.0.0.1:{proxy.port}"), "--timeout", "0.1 s",
                                          "--apply", "--json", timeout=120)
                faults += len(proxy.faults)
            self.assertIn(answer.code, (0, 1, 4), answer)
            outcomes.add(answer.code)
            has_written = any('"write"' in path.read_text() for path in self.journals("tune"))
            if answer.code == 4 and has_written:
                self.assertRegex(answer.err, "safe state|SAFE STATE", answer)
            self.put_back(direct)
            self.assertEqual(self.changed(direct), set(), answer)
        self.assertLessEqual({0, 4}, outcomes)

    def test_killed_at_any_moment_everything_goes_back(self):
        twin = self.twin()
        device = self.device(twin.where[0])
        self.run_program("backup", *device, "-o", "before.json")
        begun = time.monotonic()
        self.assertEqual(self.tune(motor(), *device, "--apply", timeout=60).code, 0)
        whole = time.monotonic() - begun  # on this machine, as busy as it is
        self.put_back(device)
        draw = random.Random(7)
        changed, kills = 0, 5 * SOAK
        for i in range(kills):
            process = subprocess.Popen([program(), "tune", self.write_model(motor()), *device, "--apply"],
                                       cwd=self.folder, env=self.environment, stdout=subprocess.DEVNULL,
                                       stderr=subprocess.DEVNULL)
            time.sleep((i + draw.random()) / kills * whole)
            process.kill()
            process.wait()
            changed += len(self.changed(device)) > 0
            self.put_back(device)
            self.assertEqual(self.changed(device), set())
        self.assertGreater(changed, 0)

    def test_a_reader_of_the_progress_that_goes_away_changes_nothing(self):
        twin = self.twin()
        device = self.device(twin.where[0])
        self.run_program("backup", *device, "-o", "before.json")
        answer = self.run_unheard("tune", self.write_model(motor()), *device, "--apply", "-o", "tuned.json")
        self.assertEqual(answer.code, 0, answer)
        result = json.loads((self.folder / "tuned.json").read_text())
        self.assertEqual((result["outcome"], result["state"]), ("reached", "changed"))

    def test_a_fault_of_the_session_before_does_not_stand_in_the_way(self):
        twin = self.twin("--velocity-limit", "20 rad/s")
        device = self.device(twin.where[0])
        self.run_program("backup", *device, "-o", "before.json")
        for again in (False, True):  # overspeed, each time anew
            answer = self.tune(motor(), *device, "--apply", "--current", "1 A")
            self.assertEqual(answer.code, 4, answer)
            self.assertIn("during the excitation: overspeed", answer.err)
            self.assertEqual("from before is cleared: overspeed" in answer.err, again, answer)
            self.assertEqual(self.changed(device), set())

    def test_ctrl_c_leaves_it_safe_and_as_it_was(self):
        twin = self.twin()
        device = self.device(twin.where[0])
        self.run_program("backup", *device, "-o", "before.json")
        process = subprocess.Popen([program(), "tune", self.write_model(motor()), *device, "--apply"], cwd=self.folder,
                                   env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        time.sleep(1)
        process.send_signal(2)
        _, err = process.communicate(timeout=20)
        self.assertEqual(process.returncode, 130, err)
        self.assertIn("safe state", err)
        self.assertEqual(self.changed(device), set())


if __name__ == "__main__":
    unittest.main()
