"""identify against the twin, and against an amplifier of pymodbus with the second profile."""
import json
import signal
import subprocess
import time
import unittest

from peer import Peer
from program import DeviceTest, load_example, program, with_value
from twin_test import Twin

TRUTH = {"resistance": 1.5, "inductance": 0.5e-3, "torque_constant": 0.05, "inertia": 2e-5, "damping": 1e-4,
         "coulomb_friction": 1e-3, "bandwidth": 1200, "delay": 150e-6}


class IdentifyTest(DeviceTest):

    def model(self, **values):
        """The example display with friction, a bandwidth, a delay and an encoder."""
        model = load_example()
        for path, value in {"/mechanics/coulomb_friction": 1e-3, "/amplifier/bandwidth": "1.2 kHz",
                            "/sampling/delay": "150 us", "/sensor/quantum": "8192 counts/rev", **values}.items():
            model = with_value(model, path, value) if self.has(model, path) else self.added(model, path, value)
        (self.folder / "device.json").write_text(json.dumps(model))
        return "device.json"

    @staticmethod
    def has(model, path):
        *parents, last = path.strip("/").split("/")
        for key in parents:
            model = model[key]
        return last in model

    @staticmethod
    def added(model, path, value):
        model = json.loads(json.dumps(model))
        *parents, last = path.strip("/").split("/")
        place = model
        for key in parents:
            place = place[key]
        place[last] = value
        return model

    def twin(self, *options, **values):
        if "--winding-rise" not in options:
            options = ("--winding-rise", "20", *options)
        twin = Twin("--listen", "127.0.0.1:0", *options, model=self.model(**values), folder=self.folder)
        self.addCleanup(twin.__exit__)
        return twin

    def identify(self, where, *options, profile="gyrator_twin", **more):
        return self.run_program("identify", "--connect", where, "--profile", profile, *options,
                                **more)

    def backup(self, where, name, profile="gyrator_twin"):
        self.assertEqual(self.run_program("backup", "--connect", where, "--profile", profile, "-o", name).code, 0)
        return {s["register"]: s["words"] for s in json.loads((self.folder / name).read_text())["settings"]}

    def assert_covers(self, parameter, truth):
        self.assertTrue(parameter["identifiable"], parameter)
        self.assertLessEqual(parameter["low"], truth, parameter)
        self.assertGreaterEqual(parameter["high"], truth, parameter)


class TwinIdentifyTest(IdentifyTest):

    def test_a_dry_run_says_what_it_would_do_and_does_nothing(self):
        twin = self.twin("--time-scale", "max")
        before = self.backup(twin.where[0], "before.json")
        answer = self.identify(twin.where[0])
        self.assertEqual(answer.code, 0, answer)
        for words in ("winding and amplifier", "friction", "damping_connected", "excitation_amplitude", "Dry run",
                      "excitation_end_frequency", "excitation_run", "capture_arm", "watchdog", "advance_time"):
            self.assertIn(words, answer.out)
        self.assertEqual(self.backup(twin.where[0], "after.json"), before)
        answer = self.identify(twin.where[0], "--json")
        result = json.loads(answer.out)
        self.assertEqual((result["applied"], result["state"], result["outcome"]), (False, "safe", "planned"))
        self.assertIn("damping_connected", [row["register"] for row in result["plan"]])
        code, err = twin.stop()
        self.assertEqual(code, 0)
        self.assertIn("faults: none", err)

    def test_every_parameter_is_found_and_every_setting_put_back(self):
        twin = self.twin("--time-scale", "max")
        before = self.backup(twin.where[0], "before.json")
        begun = time.monotonic()
        answer = self.identify(twin.where[0], "--apply", "--json", "-o", "motor.json", "--result", "result.json",
                               "--svg", "result.svg", "--csv", "sines.csv")
        self.assertLess(time.monotonic() - begun, 20)
        self.assertEqual(answer.code, 0, answer)
        result = json.loads(answer.out)
        self.assertLess(result["duration_s"], 40)
        self.assertEqual((result["applied"], result["state"]), (True, "safe"))
        parameters = {p["name"]: p for p in result["parameters"]}
        for name, truth in TRUTH.items():
            self.assert_covers(parameters[name], truth)
        self.assertGreater(parameters["resistance_as_measured"]["low"], 1.5)
        self.assertEqual(self.backup(twin.where[0], "after.json"), before)
        self.check_files(parameters)
        # One line for each experiment, with the time at which it began.
        self.assertIn("winding and amplifier: sine of", answer.err)

    def check_files(self, parameters):
        model = json.loads((self.folder / "motor.json").read_text())
        self.assertIn(" to ", model["motor"]["resistance"])
        done = self.run_program("impedance", "motor.json", "--json", "--frequency", "10")
        self.assertEqual(done.code, 0, done)
        held = json.loads(self.run_program("tolerance", "motor.json", "--json", "--samples", "50").out or "{}")
        self.assertIsInstance(held, dict)
        self.assertIn("</svg>", (self.folder / "result.svg").read_text())
        self.assertGreater(len((self.folder / "sines.csv").read_text().splitlines()), 15)
        report = self.run_program("report", "result.json", "-o", "report.html")
        self.assertEqual(report.code, 0, report)
        self.assertIn("torque_constant", (self.folder / "report.html").read_text())
        self.assertEqual(parameters["inertia"]["unit"], "kg.m^2")

    def test_a_base_keeps_all_that_was_not_identified(self):
        twin = self.twin("--time-scale", "max")
        base = with_value(load_example(), "/motor/resistance", "1.2 ohm")
        (self.folder / "base.json").write_text(json.dumps(base))
        answer = self.identify(twin.where[0], "--apply", "--quiet", "--model", "base.json", "-o", "motor.json")
        self.assertEqual((answer.code, answer.out, answer.err), (0, "", ""))
        model = json.loads((self.folder / "motor.json").read_text())
        self.assertEqual(model["controller"], base["controller"])
        self.assertEqual(model["damping"], base["damping"])
        self.assertAlmostEqual(float(model["motor"]["resistance"].split()[0]), 1.5, delta=0.03)
        self.assertEqual(self.run_program("passivity", "motor.json", "--quiet").code, 1)  # as the example is

    def test_a_fault_ends_it_with_everything_put_back(self):
        twin = self.twin("--time-scale", "max", "--winding-rise", "96")
        before = self.backup(twin.where[0], "before.json")
        answer = self.identify(twin.where[0], "--apply", "-o", "motor.json")
        self.assertEqual(answer.code, 4, answer)
        self.assertFalse((self.folder / "motor.json").exists())
        self.assertEqual(self.backup(twin.where[0], "after.json"), before)

    def test_an_interrupt_ends_it_with_everything_put_back(self):
        twin = self.twin()
        before = self.backup(twin.where[0], "before.json")
        words = [program(), "identify", "--connect", twin.where[0], "--profile", "gyrator_twin", "--apply"]
        # timeout(1) and a closing terminal say it twice.
        for signals in ((signal.SIGINT,), (signal.SIGTERM, signal.SIGTERM), (signal.SIGHUP, signal.SIGHUP)):
            with subprocess.Popen(words, cwd=self.folder, env=self.environment, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, text=True) as process:
                for _ in range(3):
                    process.stderr.readline()
                for each in signals:
                    process.send_signal(each)
                    time.sleep(0.002)
                out, err = process.communicate(timeout=20)
            self.assertEqual(process.returncode, 130, err)
            self.assertEqual(out, "")
            self.assertEqual(self.backup(twin.where[0], "after.json"), before)

    def test_a_reader_that_goes_away_changes_nothing(self):
        twin = self.twin("--time-scale", "max")
        before = self.backup(twin.where[0], "before.json")
        for broken, code in (("stderr", 0), ("stdout", 2)):
            answer = self.run_unheard("identify", "--connect", twin.where[0], "--profile", "gyrator_twin", "--apply",
                                      broken=broken)
            self.assertEqual(answer.code, code, answer)
            if broken == "stdout":
                self.assertIn("stdout: cannot be written", answer.err)
            self.assertEqual(self.backup(twin.where[0], "after.json"), before)

    def test_bad_input_names_the_option(self):
        for options, words in ((("--share", "200 %"), "--share: 200 %: must be from 2 % to 90 %"),
                               (("--slow", "3 A"), "--slow"),
                               (("--motion", "round"), "--motion"),
                               (("--model", "nowhere.json"), "nowhere.json"),
                               (("-o", "a.json", "--result", "a.json"), "would overwrite")):
            answer = self.identify("tcp://127.0.0.1:1", *options)
            self.assertEqual(answer.code, 2, answer)
            self.assertIn(words, answer.err)
        self.assertEqual(self.run_program("identify", "--profile", "gyrator_twin").code, 2)


class PeerIdentifyTest(IdentifyTest):

    def test_the_amplifier_of_others_is_identified_over_the_second_profile(self):
        peer = Peer(log=self.folder / "writes.jsonl")
        self.addCleanup(peer.close)
        before = self.backup(peer.url, "before.json", "integer_drive")
        answer = self.identify(peer.url, "--apply", "--json", "--slow", "2 Hz", profile="integer_drive",
                               timeout=60)
        self.assertEqual(answer.code, 0, answer)
        parameters = {p["name"]: p for p in json.loads(answer.out)["parameters"]}
        for name in ("resistance", "torque_constant", "inertia"):
            self.assertTrue(parameters[name]["identifiable"], parameters[name])
        self.assertEqual(self.backup(peer.url, "after.json", "integer_drive"), before)


if __name__ == "__main__":
    unittest.main()
