"""gyrator study: sweeps through the program, whole or killed on the way, on threads and in processes."""
import csv
import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import time
import unittest
from pathlib import Path

from program import EXAMPLES, PATIENCE_S, ProgramTest, RC_DISPLAY, ROOT, load_example, program, with_value

GRID = ("--vary", "damping.0.capacitance=100uF..10mF:7log", "--vary", "controller.damping=0,0.15 mN.m.s/rad,1e-4",
        "--analysis", "zwidth")
# Points of some thousandths of a second each, 600 of them, so that a kill finds work under way.
LONG = ("--vary", "controller.stiffness=0.01..0.5:30", "--vary", "mechanics.inertia=1e-5..4e-5:20",
        "--analysis", "zwidth")
# A winding that is cancelled by more than all of it oscillates.
CANCELLED = {"kind": "resistance_cancellation", "fraction": 0.5}


# Without the kernel's cross-memory copy, which containers forbid; and MPI itself leaks a little.
MPI_ENVIRONMENT = {"OMPI_MCA_btl_vader_single_copy_mechanism": "none", "ASAN_OPTIONS": "detect_leaks=0"}


class SweepTest(ProgramTest):

    def setUp(self):
        super().setUp()
        self.model = self.write_model(RC_DISPLAY.read_bytes(), "rc.json")

    def sweep(self, *arguments, model=None, output="sweep.h5", code=0):
        answer = self.run_program("study", "run", model or self.model, *arguments, "-o", output,
                                  timeout=3 * PATIENCE_S)
        self.assertEqual(answer.code, code, answer)
        return answer

    def show(self, name="sweep.h5"):
        answer = self.run_program("study", "show", name, "--json")
        self.assertEqual(answer.code, 0, answer)
        table = answer.json
        table["column"] = {column["name"]: column["values"] for column in table["columns"]}
        table["unit"] = {column["name"]: column["unit"] for column in table["columns"]}
        return table

    def read(self, name):
        return (self.folder / name).read_bytes()

    def cancelling_model(self):
        model = with_value(load_example(), "/damping", [CANCELLED])
        model["amplifier"] = {"kind": "voltage"}
        return self.write_model(model, "cancelling.json")


class ResultTest(SweepTest):

    def test_a_grid_has_every_combination_and_the_last_varies_fastest(self):
        self.sweep(*GRID)
        table = self.show()
        self.assertEqual((table["points"], table["ok"]), (21, 21))
        self.assertEqual(table["column"]["controller.damping"], [0, 1.5e-4, 1e-4] * 7)
        capacitance = table["column"]["damping.0.capacitance"]
        self.assertEqual((capacitance[0], capacitance[-1]), (100e-6, 10e-3))
        for k in range(7):
            self.assertAlmostEqual(capacitance[3 * k] / (1e-4 * 100 ** (k / 6)), 1, delta=1e-14)
        self.assertEqual(table["unit"]["damping.0.capacitance"], "F")
        self.assertEqual(table["unit"]["max_stiffness"], "N.m/rad")
        self.assertEqual(table["unit"]["worst_frequency_hz"], "Hz")
        self.assertEqual(self.files(), ["rc.json", "sweep.h5"])

    def test_a_point_is_what_the_command_says_of_its_model(self):
        self.sweep(*GRID)
        table = self.show()
        for point in (0, 10, 20):
            model = with_value(load_example(), "/damping/0/capacitance",
                               table["column"]["damping.0.capacitance"][point])
            name = self.write_model(model, "one.json")
            answer = self.ask("zwidth", name, "--damping", table["column"]["controller.damping"][point],
                              "--criterion", "exact_disk")
            self.assertEqual(table["column"]["max_stiffness"][point], answer["max_stiffness"][0])

    def test_every_analysis_gives_what_its_command_gives(self):
        self.sweep("--vary", "controller.stiffness=0.05,0.4", "--analysis", "passivity", output="p.h5")
        self.sweep("--vary", "controller.stiffness=0.05,4", "--analysis", "simulate", output="s.h5")
        self.sweep("--vary", "controller.stiffness=0.05,0.4", "--analysis", "coupled", output="c.h5")
        passivity, simulate, coupled = self.show("p.h5"), self.show("s.h5"), self.show("c.h5")
        for i, stiffness in enumerate((0.05, 0.4)):
            name = self.write_model(with_value(load_example(), "/controller/stiffness", stiffness), "one.json")
            judged = self.ask("passivity", name)
            exact = next(c for c in judged["criteria"] if c["name"] == "exact_disk")
            self.assertEqual(passivity["column"]["passive"][i], float(judged["verdict"] == "passive"))
            for key in ("margin", "worst_frequency_hz", "max_stiffness"):
                self.assertEqual(passivity["column"][key][i], exact[key])
            limit = self.ask("zwidth", name, "--damping", 1.5e-4, "--criterion", "coupled")
            self.assertEqual(coupled["column"]["max_stiffness"][i], limit["max_stiffness"][0])
        for i, stiffness in enumerate((0.05, 4)):
            name = self.write_model(with_value(load_example(), "/controller/stiffness", stiffness), "one.json")
            run = self.ask("simulate", name)
            self.assertEqual(("settles", "limit_cycle", "diverges")[int(simulate["column"]["outcome"][i])],
                             run["classification"])
            self.assertEqual(simulate["column"]["growth"][i], run["growth"])
            self.assertEqual(simulate["column"]["amplitude"][i], run["oscillation"]["amplitude"])

    def test_the_file_says_where_it_comes_from(self):
        self.sweep(*GRID)
        said = self.show()["attributes"]
        text = RC_DISPLAY.read_bytes()
        self.assertEqual(said["model"], text.decode())
        self.assertEqual(said["model_sha256"], hashlib.sha256(text).hexdigest())
        self.assertEqual((said["sampling"], said["seed"], said["analysis"]), ("grid", 1, "zwidth"))
        self.assertTrue(said["program"].startswith("gyrator "))
        self.assertTrue(said["command_line"].startswith("gyrator study run rc.json --vary damping.0"))

    def test_a_study_file_gives_the_same_numbers_as_options(self):
        self.sweep(*GRID)
        study = {"schema": "gyrator/study/1", "model": "rc.json", "analysis": "zwidth",
                 "vary": [{"path": "damping.0.capacitance", "from": "100 uF", "to": "10 mF", "points": 7,
                           "scale": "log"},
                          {"path": "controller.damping", "values": [0, "0.15 mN.m.s/rad", 1e-4]}]}
        (self.folder / "study.json").write_text(json.dumps(study))
        self.sweep(model="study.json", output="other.h5")
        self.assertEqual(self.show()["column"], self.show("other.h5")["column"])

    def test_sobol_and_random_points_are_the_same_again_and_another_seed_gives_others(self):
        vary = ("--vary", "damping.0.capacitance=100uF..10mF:log", "--vary", "mechanics.inertia=1e-5..3e-5",
                "--analysis", "zwidth")
        self.sweep(*vary, "--sobol", 4)
        capacitance = self.show()["column"]["damping.0.capacitance"]
        for got, share in zip(capacitance, (0.5, 0.75, 0.25, 0.375)):
            self.assertAlmostEqual(got / (1e-4 * 100 ** share), 1, delta=1e-14)
        for name, seed in (("a.h5", 7), ("b.h5", 7), ("c.h5", 8)):
            self.sweep(*vary, "--random", 5, "--seed", seed, output=name)
        self.assertEqual(self.read("a.h5"), self.read("b.h5"))
        self.assertNotEqual(self.show("a.h5")["column"], self.show("c.h5")["column"])
        # A point has a stream of its own: more points begin with the same ones.
        self.sweep(*vary, "--random", 3, "--seed", 7, output="d.h5")
        self.assertEqual(self.show("a.h5")["column"]["mechanics.inertia"][:3],
                         self.show("d.h5")["column"]["mechanics.inertia"])

    def test_csv_has_every_point_with_units(self):
        self.sweep(*GRID)
        answer = self.run_program("study", "show", "sweep.h5", "--csv", "sweep.csv")
        self.assertIn("21 points: 21 ok", answer.out)
        with open(self.folder / "sweep.csv", newline="") as file:
            rows = list(csv.reader(file))
        self.assertEqual(rows[0][:3], ["point", "damping.0.capacitance [F]", "controller.damping [N.m.s/rad]"])
        self.assertEqual([float(row[3]) for row in rows[1:]], self.show()["column"]["max_stiffness"])

    def test_other_programs_read_the_file(self):
        if shutil.which("h5dump") is None:
            self.skipTest("h5dump is not installed")
        self.sweep("--vary", "controller.stiffness=0.1,0.2", "--analysis", "zwidth")
        text = subprocess.run(["h5dump", "-A", self.folder / "sweep.h5"], capture_output=True, text=True,
                              check=True).stdout
        for part in ('DATASET "controller.stiffness"', 'DATASET "status"', 'ATTRIBUTE "unit"', '"N.m/rad"',
                     'ATTRIBUTE "model_sha256"'):
            self.assertIn(part, text)


class RefusedTest(SweepTest):

    def test_what_cannot_vary_is_refused_by_name(self):
        for vary, *fragments in (
                ("damping.0.capacitence=1uF,2uF", "capacitence", "did you mean 'capacitance'"),
                ("dampping.0.capacitance=1uF", "did you mean 'damping'"),
                ("damping.1.capacitance=1uF", "'1'", "from 0 to 0"),
                ("damping.0=1", "several values", "capacitance"),
                ("damping.0.kind=rc", "decides"),
                ("mechanics.transmission.stiffness=1", "no 'mechanics.transmission'"),
                ("damping.0.capacitance=1ohm,2ohm", "resistance", "capacitance [F]"),
                ("damping.0.capacitance=-1uF..1uF:3", "above 0"),
                ("damping.0.capacitance=100..500uF:3", "only one end"),
                ("damping.0.capacitance=1uF..1mF", "number of points"),
                ("damping.0.capacitance=1uF..1mF:x", "number of points"),
                ("sensor.quantum=0..1:3log", "logarithmic"),
                ("controller.unilateral=yes", "true or false"),
                ("amplifier.sense=total,moter", "did you mean 'motor'"),
                ("damping.0.capacitance", "PATH=")):
            with self.subTest(vary=vary):
                answer = self.run_program("study", "run", self.model, "--vary", vary, "--analysis", "zwidth", "-o",
                                          "sweep.h5")
                self.assert_refused(answer, "--vary", *fragments)
        self.assertEqual(self.files(), ["rc.json"])

    def test_the_rest_of_the_command_line_is_checked_too(self):
        vary = ("--vary", "controller.stiffness=0.1")
        for arguments, fragment in (((*vary, "--analysis", "zwith"), "did you mean 'zwidth'"),
                                    ((*vary,), "--analysis"),
                                    (("--analysis", "zwidth"), "nothing varies"),
                                    ((*vary, *vary, "--analysis", "zwidth"), "varies twice"),
                                    ((*vary, "--analysis", "zwidth", "--seed", "3"), "--random"),
                                    ((*vary, "--analysis", "zwidth", "--threads", "0"), "--threads"),
                                    ((*vary, "--anlysis", "zwidth"), "did you mean '--analysis'")):
            answer = self.run_program("study", "run", self.model, *arguments, "-o", "sweep.h5")
            with self.subTest(arguments=arguments):
                self.assert_refused(answer, fragment)
        self.assert_refused(self.run_program("study", "run", self.model, *vary, "--analysis", "zwidth", "-o", "e.csv"),
                            "e.csv", ".h5 or .hdf5")
        self.assert_refused(self.run_program("study", "run", self.model, "--anlysis", "zwidth"), "study run: ",
                            "`gyrator study run --help`")
        self.assert_refused(self.run_program("study", "rum"), "did you mean 'run'", "`gyrator study --help`")
        self.assert_refused(self.run_program("study"), "run, show")
        self.assert_refused(self.run_program("study", "show", "rc.json"), "rc.json")
        self.assert_refused(self.run_program("study", "run", self.model, *vary, "--analysis", "zwidth", "-o",
                                             self.model), "would overwrite")

    def test_a_study_file_is_read_as_strictly_as_a_model(self):
        good = {"schema": "gyrator/study/1", "model": "rc.json", "analysis": "zwidth",
                "vary": [{"path": "controller.stiffness", "values": [0.1]}]}
        for change, fragment in (({"analysis": "zwith"}, "did you mean 'zwidth'"), ({"modle": 1}, "modle"),
                                 ({"vary": []}, "/vary"), ({"model": "rd.json"}, "rc.json"),
                                 ({"vary": [{"path": "controller.stifness", "values": [1]}]}, "/vary/0"),
                                 ({"vary": [{"path": "controller.stiffness", "from": 1}]}, "\"to\"")):
            (self.folder / "study.json").write_text(json.dumps(good | change))
            with self.subTest(change=change):
                self.assert_refused(self.run_program("study", "run", "study.json", "-o", "s.h5"), fragment)


class FailureTest(SweepTest):

    VARY = ("--vary", "damping.0.fraction=0.5,0.9,1.5,0.7", "--analysis", "zwidth")

    def test_the_first_failed_point_stops_the_sweep_with_its_reason(self):
        answer = self.sweep(*self.VARY, "--threads", 1, model=self.cancelling_model(), code=2)
        self.assertIn("point 2 (damping.0.fraction = 1.5)", answer.err)
        self.assertIn("2 of 4 points are kept in sweep.h5.journal", answer.err)
        self.assertIn("--keep-going", answer.err)
        self.assertNotIn("sweep.h5", self.files())

    def test_a_failed_point_is_recorded_and_the_rest_goes_on(self):
        model = self.cancelling_model()
        self.sweep(*self.VARY, "--threads", 1, model=model, code=2)
        answer = self.sweep(*self.VARY, "--keep-going", model=model)
        self.assertIn("4 points: 3 ok, 1 failed (2 by an earlier run)", answer.out)
        table = self.show()
        self.assertEqual(table["column"]["status"], [0, 0, 1, 0])
        self.assertTrue(table["column"]["reason"][2])
        self.assertEqual(table["column"]["reason"][:2] + table["column"]["reason"][3:], [""] * 3)
        self.assertIsNone(table["column"]["max_stiffness"][2])
        self.assertNotIn("sweep.h5.journal", self.files())

    def test_a_sweep_without_one_good_point_is_a_failure(self):
        answer = self.sweep("--vary", "damping.0.fraction=1.5,2", "--analysis", "zwidth", "--keep-going",
                            model=self.cancelling_model(), code=3)
        self.assertIn("not one of 2 points", answer.err)
        self.assertEqual(self.show()["column"]["status"], [1, 1])

    def test_a_point_that_takes_too_long_is_timed_out(self):
        vary = ("--vary", "simulation.duration=10 ms,3000 s,20 ms", "--analysis", "simulate", "--timeout", "100 ms")
        begun = time.monotonic()
        answer = self.sweep(*vary, "--keep-going")
        self.assertLess(time.monotonic() - begun, 10)
        self.assertIn("2 ok, 1 timed out", answer.out)
        table = self.show()
        self.assertEqual(table["column"]["status"], [0, 2, 0])
        self.assertEqual(table["column"]["reason"][1], "not done within 0.1 s")
        self.assertIn("not done within 0.1 s", self.sweep(*vary, output="other.h5", code=3).err)


class JournalTest(SweepTest):

    def start(self, *arguments, output="sweep.h5"):
        return subprocess.Popen([program(), "study", "run", self.model, *map(str, arguments), "-o", output],
                                cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def kill_after(self, process, seconds):
        time.sleep(seconds)
        process.kill()
        process.communicate()

    def kill_in_the_middle(self, more=8000):
        """A run that is killed when its journal has grown by so many bytes."""
        journal = self.folder / "sweep.h5.journal"
        size = lambda: journal.stat().st_size if journal.exists() else 0
        wanted = size() + more
        process = self.start(*LONG, "--threads", 1)
        until = time.monotonic() + PATIENCE_S
        while process.poll() is None and size() < wanted and time.monotonic() < until:
            time.sleep(0.005)
        self.assertIsNone(process.poll(), "over before it could be killed")
        self.kill_after(process, 0)

    def test_the_bytes_do_not_depend_on_threads(self):
        for threads in (1, 2, 5):
            self.sweep(*GRID, "--threads", threads, output=f"{threads}.h5")
        self.assertEqual(self.read("1.h5"), self.read("2.h5"))
        self.assertEqual(self.read("1.h5"), self.read("5.h5"))

    def test_killed_at_any_moment_and_resumed_gives_the_bytes_of_an_undisturbed_run(self):
        begun = time.monotonic()
        self.sweep(*LONG, output="whole.h5")
        whole_s = time.monotonic() - begun
        moments = random.Random(5)
        kills = resumed_total = 0
        for _ in range(10):
            self.kill_after(self.start(*LONG), moments.uniform(0, whole_s))
            kills += (self.folder / "sweep.h5.journal").exists()
            answer = self.sweep(*LONG, "--json")
            resumed_total += answer.json["resumed"]
            self.assertEqual(self.read("sweep.h5"), self.read("whole.h5"))
            self.assertNotIn("sweep.h5.journal", self.files())
        self.assertGreater(kills, 3, "too few of the runs were killed on the way")
        self.assertGreater(resumed_total, 0, "nothing was taken from a journal")

    def test_killed_again_and_again_it_still_ends_and_computes_nothing_twice(self):
        self.sweep(*LONG, output="whole.h5")
        done = 0
        for _ in range(4):
            self.kill_in_the_middle(more=2500)
            now = self.show("sweep.h5.journal")
            self.assertGreater(now["ok"], done, "nothing new was kept, or what was kept is lost")
            done = now["ok"]
        answer = self.sweep(*LONG, "--json")
        self.assertGreaterEqual(answer.json["resumed"], done)
        self.assertEqual(self.read("sweep.h5"), self.read("whole.h5"))

    def test_a_torn_record_is_dropped_and_computed_again(self):
        self.sweep(*LONG, output="whole.h5")
        self.kill_in_the_middle()
        journal = self.folder / "sweep.h5.journal"
        self.assertTrue(journal.exists())
        kept = self.show("sweep.h5.journal")["ok"]
        journal.write_bytes(journal.read_bytes()[:-5])
        torn = self.show("sweep.h5.journal")["ok"]
        self.assertLess(torn, kept)
        self.assertEqual(self.sweep(*LONG, "--json").json["resumed"], torn)
        self.assertEqual(self.read("sweep.h5"), self.read("whole.h5"))

    def test_ctrl_c_says_what_is_kept_and_the_same_command_goes_on(self):
        self.sweep(*LONG, "--keep-going", output="whole.h5")
        answer = self.interrupt("study", "run", self.model, *LONG, "--threads", 1, "--keep-going", "-o", "sweep.h5")
        self.assertEqual(answer.code, 130, answer)
        self.assertRegex(answer.err, r"interrupted: \d+ of 600 points are kept in sweep.h5.journal; the same command")
        self.assertNotIn("sweep.h5", self.files())
        kept = int(answer.err.split("interrupted: ")[1].split()[0])
        self.assertEqual(self.sweep(*LONG, "--keep-going", "--json").json["resumed"], kept)
        self.assertEqual(self.read("sweep.h5"), self.read("whole.h5"))

    def test_the_journal_of_another_study_is_refused_unless_thrown_away(self):
        self.kill_in_the_middle()
        journal = self.folder / "sweep.h5.journal"
        self.assertTrue(journal.exists())
        before = journal.read_bytes()
        answer = self.run_program("study", "run", self.model, *GRID, "-o", "sweep.h5")
        self.assert_refused(answer, "another study", "other values vary", "--restart")
        self.write_model(with_value(load_example(), "/motor/resistance", 2), "rc.json")
        answer = self.run_program("study", "run", self.model, *LONG, "-o", "sweep.h5")
        self.assert_refused(answer, "its model has another text")
        self.assertEqual(journal.read_bytes(), before)
        self.sweep(*GRID, "--restart")
        self.assertEqual(self.show()["points"], 21)
        journal.write_text("my notes")
        self.assert_refused(self.run_program("study", "run", self.model, *GRID, "-o", "sweep.h5"), "is no journal")
        self.assertEqual(journal.read_text(), "my notes")

    def test_a_file_that_a_netlist_includes_is_part_of_the_study(self):
        (self.folder / "inc").mkdir()
        (self.folder / "snubber.cir").write_text("* snubber\n.include inc/outer.inc\n.subckt snubber a b\n"
                                                 "R1 a m {r}\nC1 m b 2200u\n.ends\n")
        (self.folder / "inc/outer.inc").write_text(".inc value.inc\n")
        (self.folder / "inc/value.inc").write_text(".param r=5\n")
        model = with_value(load_example(), "/damping", [
            {"kind": "netlist", "file": "snubber.cir", "subckt": "snubber"}])
        name = self.write_model(model, "netlist.json")
        # The last value fails, so that a journal is left.
        arguments = ("--vary", "controller.stiffness=0.1,0.2", "--vary", "simulation.duration=10 ms,3000 s",
                     "--analysis", "simulate", "--timeout", "100 ms", "--threads", 1)
        self.assertIn("1 of 4 points are kept", self.sweep(*arguments, model=name, code=3).err)
        self.assertIn("1 of 4 points are kept", self.sweep(*arguments, model=name, code=3).err)
        (self.folder / "inc/value.inc").write_text(".param r=6\n")
        answer = self.sweep(*arguments, model=name, code=2)
        self.assertIn("includes, has another content", answer.err)
        self.sweep(*arguments, "--restart", model=name, code=3)

    def test_two_runs_do_not_write_one_result(self):
        process = self.start(*LONG, "--threads", 1)
        try:
            time.sleep(0.4)
            answer = self.run_program("study", "run", self.model, *LONG, "-o", "sweep.h5")
            self.assert_refused(answer, "another run")
        finally:
            process.kill()
            process.communicate()

    def test_a_journal_shows_what_is_there(self):
        self.kill_in_the_middle()
        answer = self.run_program("study", "show", "sweep.h5.journal", "--csv", "part.csv")
        self.assertEqual(answer.code, 0, answer)
        self.assertRegex(answer.out, r"600 points: \d+ ok, \d+ not computed yet")
        rows = (self.folder / "part.csv").read_text().splitlines()
        self.assertEqual(len(rows) - 1, self.show("sweep.h5.journal")["ok"])


@unittest.skipIf(shutil.which("mpirun") is None, "mpirun is not installed")
class ProcessesTest(SweepTest):

    def mpirun(self, processes, *arguments, timeout=60):
        words = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", processes, program(), "study", "run",
                 *arguments]
        return subprocess.run(list(map(str, words)), cwd=self.folder, capture_output=True, text=True, timeout=timeout,
                              stdin=subprocess.DEVNULL, env=os.environ | MPI_ENVIRONMENT)

    def test_the_bytes_do_not_depend_on_processes(self):
        self.sweep(*LONG, output="whole.h5")
        for processes, threads in ((1, 1), (2, 1), (3, 1), (2, 2)):
            name = f"{processes}-{threads}.h5"
            done = self.mpirun(processes, self.model, *LONG, "--threads", threads, "-o", name)
            with self.subTest(processes=processes, threads=threads):
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(done.stdout.count("600 points: 600 ok"), 1, done.stdout)
                self.assertEqual(self.read(name), self.read("whole.h5"))
                self.assertNotIn(f"{name}.journal", self.files())

    def test_a_run_in_processes_is_resumed_on_threads(self):
        self.sweep(*LONG, output="whole.h5")
        words = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", "3", program(), "study", "run", self.model,
                 *LONG, "-o", "sweep.h5"]
        process = subprocess.Popen(words, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                   env=os.environ | MPI_ENVIRONMENT)
        journal = self.folder / "sweep.h5.journal"
        until = time.monotonic() + PATIENCE_S
        while time.monotonic() < until and not (journal.exists() and journal.stat().st_size > 6000):
            time.sleep(0.02)
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        self.assertEqual(len(children), 3)
        for pid in children:
            os.kill(int(pid), signal.SIGKILL)
        process.wait(PATIENCE_S)
        self.assertTrue(journal.exists())
        self.assertGreater(self.sweep(*LONG, "--json").json["resumed"], 0)
        self.assertEqual(self.read("sweep.h5"), self.read("whole.h5"))

    def test_a_full_disk_ends_all_processes_with_its_reason(self):
        # 8 kB for a file: the journal's header fits, the results of all points do not.
        shell = "trap '' XFSZ; test \"$OMPI_COMM_WORLD_RANK\" = 0 && ulimit -f 16; exec \"$@\""
        words = ["mpirun", "--allow-run-as-root", "--oversubscribe", "--mca", "btl", "self,tcp", "-n", "2", "sh", "-c",
                 shell, "sh", program(), "study", "run", self.model, *LONG, "-o", "sweep.h5"]
        done = subprocess.run(words, cwd=self.folder, capture_output=True, text=True, timeout=60,
                              stdin=subprocess.DEVNULL, env=os.environ | MPI_ENVIRONMENT)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(done.stderr.count("sweep.h5.journal: cannot be written"), 1, done.stderr)

    def test_errors_are_said_once_and_end_all_processes(self):
        done = self.mpirun(3, self.model, "--vary", "damping.0.capacitence=1uF", "--analysis", "zwidth", "-o", "s.h5")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(done.stderr.count("did you mean 'capacitance'"), 1, done.stderr)
        done = self.mpirun(3, self.cancelling_model(), *FailureTest.VARY, "-o", "s.h5")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(done.stderr.count("point 2 (damping.0.fraction = 1.5)"), 1, done.stderr)
        done = self.mpirun(2, "cancelling.json", *FailureTest.VARY, "--keep-going", "-o", "s.h5")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.show("s.h5")["column"]["status"], [0, 0, 1, 0])


class ShippedTest(SweepTest):

    def test_the_shipped_schema_is_the_programs(self):
        self.assertEqual(self.run_program("schema", "--study").out,
                         (ROOT / "schemas/study.schema.json").read_text())

    def test_the_manual_has_the_programs_table(self):
        table = self.run_program("schema", "--study", "--manual").out
        self.assertIn(table.strip(), (ROOT / "docs/sweeps.md").read_text())

    def test_the_example_runs(self):
        answer = self.run_program("study", "run", EXAMPLES / "sweep/capacitance.json", "-o", "sweep.h5")
        self.assertEqual(answer.code, 0, answer)

    def test_the_help_texts_example_runs(self):
        (self.folder / "examples").symlink_to(EXAMPLES)
        for inner in ("run", "show"):
            line = self.run_program("study", inner, "--help").out.split("Example:\n", 1)[1].splitlines()[0].strip()
            done = subprocess.run(["sh", "-c", line.replace("gyrator ", f"'{program()}' ", 1)], cwd=self.folder,
                                  capture_output=True, text=True, timeout=20)
            self.assertEqual((done.returncode, done.stderr), (0, ""), line)


if __name__ == "__main__":
    unittest.main()
