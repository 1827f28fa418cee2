"""gyrator study check, update and run: figures that must not change, through the program."""
import json
import os
import pty
import shutil
import subprocess
import time
import unittest
import xml.etree.ElementTree as ElementTree

from program import EXAMPLES, PATIENCE_S, ProgramTest, ROOT, load_example, program

STUDIES = sorted((ROOT / "studies").glob("*/study.json"))
LIMIT = "criteria[name=exact_disk].max_stiffness"
STUDY = {
    "schema": "gyrator/regression/1",
    "name": "Wall",
    "runs": [
        {"name": "limit", "command": "passivity", "model": "plant.json",
         "vary": {"sampling.period": ["1 ms", "2 ms"]}, "set": {"controller.stiffness": "300 N/m"},
         "expect": [{"figure": "verdict", "equals": "passive"},
                    {"name": "largest K", "figure": LIMIT, "unit": "N/m"}]},
        {"name": "hit", "command": "simulate", "model": "plant.json",
         "expect": [{"figure": "classification", "equals": "settles"}],
         "trace": {"columns": {"position": {"absolute": "1 um"}}, "time": "10 us"},
         "energy": {"residual": 1e-9}}]}
NEITHER_CI = {key: value for key, value in os.environ.items() if not key.startswith("GITHUB")}


class StudyTest(ProgramTest):

    def setUp(self):
        super().setUp()
        self.write_model(load_example("p3_plant"), "plant.json")
        self.write_study(STUDY)

    def write_study(self, study, name="study.json"):
        (self.folder / name).write_text(json.dumps(study, indent=1))

    def study(self, *arguments, code=0, environment=NEITHER_CI):
        answer = self.run_program("study", *arguments, environment=environment, timeout=3 * PATIENCE_S)
        self.assertEqual(answer.code, code, answer)
        return answer

    def change_model(self, **mechanics):
        model = load_example("p3_plant")
        model["mechanics"] |= mechanics
        self.write_model(model, "plant.json")

    def failed(self, *arguments):
        """The rows that did not pass, by run and figure."""
        rows = self.study("check", "study.json", "--json", *arguments, code=1).json["rows"]
        return {(row["run"], row["figure"]): row["explanation"] for row in rows if row["result"] == "fail"}

    def read(self, name):
        return (self.folder / name).read_text()


class CheckTest(StudyTest):

    def setUp(self):
        super().setUp()
        self.study("update", "study.json", "--yes")

    def test_what_has_not_changed_passes(self):
        answer = self.study("check", "study.json")
        self.assertRegex(answer.out, r"^study\.json: 7 figures as expected, [0-9.]+ s\n$")
        self.assertEqual(answer.err, "")

    def test_every_figure_is_printed_when_asked_for(self):
        answer = self.study("check", "study.json", "--verbose")
        self.assertRegex(answer.out, r"limit +largest K +\[1600, 800\] N/m .* pass\n")

    def test_a_difference_of_shape_is_told(self):
        self.write_study(dict(STUDY, runs=[dict(STUDY["runs"][0], expect=[{"figure": "verdict"}])]))
        self.study("update", "study.json", "--yes")
        baseline = json.loads(self.read("study.baseline.json"))
        baseline["runs"]["limit"]["figures"]["verdict"]["value"] = "passive"
        (self.folder / "study.baseline.json").write_text(json.dumps(baseline))
        self.assertEqual(self.failed()[("limit", "verdict")],
                         "verdict of limit: [passive, passive], baseline passive")

    def test_two_percent_of_damping_are_found_and_told_with_units(self):
        self.change_model(damping="0.784 N.s/m")
        answer = self.study("check", "study.json", code=1)
        self.assertIn("largest K of limit: [0] (sampling.period = 0.001): 1568 N/m, baseline 1600 N/m ± 0.0001 %: "
                      "2 % lower (the model file is not the one of the baseline)", answer.out)
        self.assertTrue(answer.out.startswith("FAIL: study.json: "), answer)
        self.assertIn("position leaves the tube at t = ", answer.out)
        self.assertEqual(set(self.failed()), {("limit", "largest K"), ("hit", "trace")})

    def test_a_change_within_tolerance_passes(self):
        study = json.loads(json.dumps(STUDY))
        study["runs"][0]["expect"][1]["tolerance"] = {"relative": "3 %"}
        study["runs"] = study["runs"][:1]
        self.write_study(study)
        self.change_model(damping="0.784 N.s/m")
        self.study("check", "study.json")
        study["runs"][0]["expect"][1]["tolerance"] = {"relative": "1.9 %"}
        self.write_study(study)
        self.study("check", "study.json", code=1)

    def test_only_the_side_that_counts_fails(self):
        study = json.loads(json.dumps(STUDY))
        study["runs"] = study["runs"][:1]
        for side, damping, code in (("below", "0.9 N.s/m", 0), ("below", "0.784 N.s/m", 1),
                                    ("above", "0.784 N.s/m", 0), ("above", "0.9 N.s/m", 1)):
            study["runs"][0]["expect"][1]["tolerance"] = {"relative": 1e-6, "side": side}
            self.write_study(study)
            self.change_model(damping=damping)
            self.study("check", "study.json", code=code)

    def test_a_published_value_is_held_too(self):
        study = json.loads(json.dumps(STUDY))
        published = {"value": [1600, 810], "relative": 1e-3, "source": "Nobody 1997"}
        study["runs"][0]["expect"][1]["published"] = published
        self.write_study(study)
        told = self.failed()[("limit", "largest K")]
        self.assertIn("800 N/m, published (Nobody 1997) 810 N/m", told)
        published["value"][1] = 800
        self.write_study(study)
        self.study("check", "study.json")

    def test_what_the_baseline_lacks_fails_and_what_the_study_lacks_is_noted(self):
        study = json.loads(json.dumps(STUDY))
        study["runs"][0]["expect"].append({"figure": "stiffness", "unit": "N/m"})
        study["runs"].append(dict(study["runs"][0], name="other"))
        self.write_study(study)
        told = self.failed()
        self.assertIn("the baseline has no such figure", told[("limit", "stiffness")])
        self.assertIn("the baseline has no such run", told[("other", "largest K")])
        self.assertIn("--filter other", told[("other", "largest K")])
        (self.folder / "study.baseline.json").unlink()
        self.assertIn("there is no baseline", self.failed()[("limit", "largest K")])
        self.write_study(STUDY)
        self.study("update", "study.json", "--yes")
        study = json.loads(json.dumps(STUDY))
        del study["runs"][0]["expect"][1], study["runs"][1]
        self.write_study(study)
        answer = self.study("check", "study.json")
        self.assertIn("limit: largest K: is in the baseline, but not in the study any more", answer.out)
        self.assertIn("hit: is in the baseline, but not in the study any more", answer.out)

    def test_another_length_and_a_lost_trace_fail(self):
        study = json.loads(json.dumps(STUDY))
        study["runs"][0]["vary"]["sampling.period"].append("3 ms")
        self.write_study(study)
        self.assertIn("3 values, baseline 2", self.failed()[("limit", "largest K")])
        self.write_study(STUDY)
        (self.folder / "study.baseline/hit.csv").unlink()
        self.assertIn("hit.csv is missing", self.failed()[("hit", "trace")])

    def test_an_unexpected_exit_code_fails_with_what_the_program_said(self):
        study = json.loads(json.dumps(STUDY))
        study["runs"][0]["set"]["controller.stiffness"] = "1000 N/m"  # passive at 1 ms only
        del study["runs"][0]["expect"][0]
        self.write_study(study)
        told = self.failed()[("limit", "exit code")]
        self.assertIn("exit code 1 (sampling.period = 0.002), expected 0", told)
        study["runs"][0]["exit_code"] = [0, 1]
        self.write_study(study)
        self.study("check", "study.json")
        study["runs"][0]["arguments"] = ["--nonsense"]
        self.write_study(study)
        told = self.failed()[("limit", "exit code")]
        self.assertIn("exit code 2", told)
        self.assertIn("unknown option '--nonsense'", told)

    def test_an_energy_ledger_that_does_not_close_fails(self):
        study = json.loads(json.dumps(STUDY))
        study["runs"][1]["arguments"] = ["--engine", "cvode", "--tolerance", "1e-5"]
        study["runs"][1]["energy"]["residual"] = 1e-13
        self.write_study(study)
        self.assertIn("of a largest energy of", self.failed()[("hit", "energy residual")])

    def test_junit_is_well_formed_and_names_the_failure(self):
        self.change_model(damping="0.784 N.s/m")
        study = dict(STUDY, name='Wall <of> "A" & B')
        self.write_study(study)
        self.study("check", "study.json", "--junit", "out.xml", "--quiet", code=1)
        suite, = ElementTree.parse(self.folder / "out.xml").getroot()
        self.assertEqual((suite.tag, suite.get("name")), ("testsuite", 'Wall <of> "A" & B'))
        cases = suite.findall("testcase")
        self.assertEqual((suite.get("tests"), suite.get("failures")), (str(len(cases)), "2"))
        self.assertGreater(sum(float(case.get("time")) for case in cases), 0)
        failed = [case for case in cases if case.find("failure") is not None]
        self.assertEqual([case.get("name") for case in failed], ["largest K", "trace"])
        self.assertIn("baseline 1600 N/m", failed[0].find("failure").get("message"))

    def test_github_is_told_only_in_github(self):
        self.change_model(damping="0.784 N.s/m")
        self.assertNotIn("::error", self.study("check", "study.json", code=1).out)
        ci = NEITHER_CI | {"GITHUB_ACTIONS": "true", "GITHUB_WORKSPACE": str(self.folder.parent)}
        lines = [line for line in self.study("check", "study.json", code=1, environment=ci).out.splitlines()
                 if line.startswith("::error")]
        self.assertEqual(len(lines), 2, lines)
        self.assertTrue(lines[0].startswith(f"::error file={self.folder.name}/study.json,title=Wall%3A limit::"),
                        lines[0])
        self.assertIn("± 0.0001 %25: 2 %25 lower", lines[0])
        answer = self.study("check", "study.json", "--json", code=1, environment=ci)
        json.loads(answer.out)  # nothing else on stdout
        self.assertIn("::error", answer.err)

    def test_a_filter_checks_and_names_only_these_runs(self):
        rows = self.study("check", "study.json", "--filter", "limit", "--json").json["rows"]
        self.assertEqual({row["run"] for row in rows}, {"limit"})
        answer = self.run_program("study", "check", "study.json", "--filter", "limmit")
        self.assert_refused(answer, "--filter", "limmit", f"{self.folder.name}/limit", "did you mean 'limit'?")
        by_folder = self.study("check", "study.json", "--filter", f"{self.folder.name}/lim", "--json").json["rows"]
        self.assertEqual([row["run"] for row in by_folder], [row["run"] for row in rows])


class UpdateTest(StudyTest):

    def test_without_a_terminal_it_needs_yes_and_leaves_nothing(self):
        before = self.files()
        answer = self.run_program("study", "update", "study.json")
        self.assert_refused(answer, "stdin is no terminal", "--yes")
        self.assertEqual(self.files(), before)

    def test_it_shows_what_changes_and_a_second_time_nothing_does(self):
        self.study("update", "study.json", "--yes")
        self.change_model(damping="0.784 N.s/m")
        answer = self.study("update", "study.json", "--yes")
        self.assertIn("limit: largest K[0]: 1600 N/m -> 1568 N/m (-2 %)", answer.out)
        self.assertIn("trace hit.csv: changed", answer.out)
        self.study("check", "study.json")
        kept = self.read("study.baseline.json")
        self.assertIn("nothing has changed", self.study("update", "study.json", "--yes").out)
        self.assertEqual(self.read("study.baseline.json"), kept)

    def test_numbers_have_unit_and_provenance(self):
        self.study("update", "study.json", "--yes")
        run = json.loads(self.read("study.baseline.json"))["runs"]["limit"]
        self.assertEqual(run["figures"]["largest K"]["unit"], "N/m")
        self.assertIn("±", run["figures"]["largest K"]["tolerance"])
        for key in ("program", "machine", "model_sha256", "command", "set", "vary"):
            self.assertIn(key, run["provenance"])
        self.assertEqual(json.loads(self.read("study.baseline.json"))["runs"]["hit"]["provenance"]["engine"], "exact")

    def test_a_filter_updates_only_these_runs(self):
        self.study("update", "study.json", "--yes")
        before = json.loads(self.read("study.baseline.json"))["runs"]
        trace = self.read("study.baseline/hit.csv")
        self.change_model(damping="0.784 N.s/m")
        self.study("update", "study.json", "--yes", "--filter", "limit")
        after = json.loads(self.read("study.baseline.json"))["runs"]
        self.assertEqual(after["hit"], before["hit"])
        self.assertEqual(self.read("study.baseline/hit.csv"), trace)
        self.assertNotEqual(after["limit"], before["limit"])

    def test_what_the_study_no_longer_has_goes(self):
        self.study("update", "study.json", "--yes")
        self.write_study(dict(STUDY, runs=STUDY["runs"][:1]))
        answer = self.study("update", "study.json", "--yes")
        self.assertIn("hit: run: removed", answer.out)
        self.assertEqual(list(json.loads(self.read("study.baseline.json"))["runs"]), ["limit"])
        self.assertEqual(list((self.folder / "study.baseline").iterdir()), [])

    def test_a_run_that_fails_is_no_reference(self):
        study = json.loads(json.dumps(STUDY))
        study["runs"][0]["expect"][0]["equals"] = "not_passive"
        self.write_study(study)
        answer = self.run_program("study", "update", "study.json", "--yes")
        self.assert_refused(answer, "study.json: limit", "not_passive is expected", "can be no reference")
        self.assertNotIn("study.baseline.json", self.files())

    def on_a_terminal(self, reply):
        leader, follower = pty.openpty()
        process = subprocess.Popen([program(), "study", "update", "study.json"], cwd=self.folder, stdin=follower,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        os.write(leader, reply.encode())
        out, err = process.communicate(timeout=PATIENCE_S)
        os.close(leader)
        os.close(follower)
        return process.returncode, out, err

    def test_on_a_terminal_it_asks(self):
        code, out, _ = self.on_a_terminal("n\n")
        self.assertEqual(code, 1, out)
        self.assertIn("write study.baseline.json? [y/N]", out)
        self.assertIn("left as it was", out)
        self.assertNotIn("study.baseline.json", self.files())
        code, out, _ = self.on_a_terminal("y\n")
        self.assertEqual(code, 0, out)
        self.assertIn("study.baseline.json", self.files())


class RunTest(StudyTest):

    def test_results_figures_and_a_page_are_written(self):
        study = dict(STUDY, figures=[{
            "name": "limits", "title": "Limits", "caption": "Over the period.",
            "x": {"label": "period", "unit": "ms"}, "y": {"label": "largest K", "unit": "N/m"},
            "curves": [{"run": "limit", "x": "set.sampling.period", "x_scale": 1000, "y": LIMIT, "title": "disk"}],
            "published": [{"title": "published", "x": [1, 2], "y": [1600, 800]}]}])
        self.write_study(study)
        self.study("run", "study.json", "-o", "out")
        names = sorted(path.name for path in (self.folder / "out").iterdir())
        self.assertEqual(names, ["hit.csv", "hit.json", "limit.0.json", "limit.1.json", "limits.svg", "report.html",
                                 "results.html"])
        result = json.loads(self.read("out/limit.1.json"))
        self.assertEqual(result["model"]["sampling"]["period"], "2 ms")
        self.assertIn("gyrator passivity plant.json", result["command_line"])
        ElementTree.parse(self.folder / "out/limits.svg")
        page = self.read("out/report.html")
        self.assertIn("Over the period.", page)
        self.assertIn("there is no baseline", page)

    def test_a_varied_array_gives_a_curve_each(self):
        study = dict(STUDY, figures=[{
            "name": "damping", "x": {"label": "frequency", "unit": "Hz", "logarithmic": True},
            "y": {"label": "damping", "unit": "N.s/m"},
            "curves": [{"run": "limit", "x": "damping_over_frequency.frequency_hz",
                        "y": "damping_over_frequency.exact"}]}])
        self.write_study(study)
        self.study("run", "study.json", "-o", "out", "--filter", "limit")
        text = self.read("out/damping.svg")
        self.assertIn("period = 0.001", text)
        self.assertIn("period = 0.002", text)

    def test_a_seed_is_the_models(self):
        run = {"name": "hit", "command": "simulate", "model": "plant.json", "seed": 42}
        self.write_study(dict(STUDY, runs=[run]))
        self.study("run", "study.json", "-o", "out")
        self.assertEqual(json.loads(self.read("out/hit.json"))["seed"], 42)

    def test_parts_of_the_model_are_replaced_whole(self):
        walls = [{"kind": "virtual_wall", "stiffness": "100 N/m", "damping": 0},
                 {"kind": "virtual_wall", "stiffness": "200 N/m", "damping": "0.1 N.s/m"}]
        run = {"name": "walls", "command": "passivity", "model": "plant.json", "vary": {"controller": walls},
               "expect": [{"figure": "stiffness", "equals": [100, 200]}, {"figure": "virtual_damping", "equals": [0, 0.1]}]}
        self.write_study(dict(STUDY, runs=[run]))
        self.study("check", "study.json")

    def test_a_run_that_goes_wrong_is_told_and_ends_with_its_code(self):
        study = json.loads(json.dumps(STUDY))
        study["runs"][1]["arguments"] = ["--nonsense"]
        self.write_study(study)
        answer = self.study("run", "study.json", "-o", "out", code=3)
        self.assertIn("exit code of hit: exit code 2, expected 0", answer.err)
        self.assertTrue((self.folder / "out/limit.0.json").exists())

    def test_no_result_overwrites_what_the_study_reads(self):
        study = json.loads(json.dumps(STUDY))
        study["runs"][1]["name"] = "plant"
        self.write_study(study)
        before = self.files()
        model = self.read("plant.json")
        answer = self.run_program("study", "run", "study.json", "-o", ".")
        self.assert_refused(answer, "--output", "the result plant.json would overwrite plant.json")
        self.assertEqual((self.files(), self.read("plant.json")), (before, model))
        self.study("run", "study.json", "-o", ".", "--filter", "limit")
        self.study("run", "study.json", "-o", ".", "--filter", "limit")  # its own results it may

    def test_a_run_without_an_answer_does_not_hide_the_page_that_tells_it(self):
        study = dict(STUDY, figures=[{
            "name": "limits", "x": {"label": "period"}, "y": {"label": "largest K"},
            "curves": [{"run": "limit", "x": "set.sampling.period", "y": LIMIT}]}])
        study["runs"] = [dict(STUDY["runs"][0], arguments=["--nonsense"])]
        self.write_study(study)
        answer = self.study("run", "study.json", "-o", "out", code=3)
        told = "the figure 'limits' is not drawn: limit (sampling.period = 0.001) gave no answer: exit code 2: "
        self.assertIn(told, answer.err)
        self.assertIn("unknown option '--nonsense'", answer.err)
        self.assertIn("gave no answer: exit code 2", self.read("out/report.html"))
        self.assertFalse((self.folder / "out/limits.svg").exists())

    def test_temporary_files_may_be_anywhere_that_is_there(self):
        nested = self.folder / "nested"
        nested.mkdir()
        for name in ("study.json", "plant.json"):
            shutil.copy(self.folder / name, nested)
        answer = self.run_program("study", "run", "nested/study.json", "-o", "out",
                                  environment=NEITHER_CI | {"TMPDIR": "nowhere"})
        self.assert_refused(answer, "TMPDIR", "nowhere")
        (self.folder / "tmp").mkdir()
        self.study("run", "nested/study.json", "-o", "out", environment=NEITHER_CI | {"TMPDIR": "tmp"})
        self.assertTrue((self.folder / "out/hit.csv").exists())

    def test_sweeps_and_regression_studies_keep_their_options_apart(self):
        self.assert_refused(self.run_program("study", "run", "study.json", "-o", "out", "--analysis", "zwidth"),
                            "study.json", "is a regression study")
        self.assert_refused(self.run_program("study", "run", "plant.json", "-o", "s.h5", "--analysis", "zwidth",
                                             "--vary", "controller.stiffness=1,2", "--filter", "x"), "--filter")
        self.assert_refused(self.run_program("study", "run", "study.json", "-o", "plant.json"), "is a file")


class BrokenStudyTest(StudyTest):

    def refused(self, *fragments, **changes):
        run = dict(STUDY["runs"][0], **changes)
        self.write_study(dict(STUDY, runs=[run]))
        self.assert_refused(self.run_program("study", "check", "study.json"), "study.json", *fragments)

    def test_slips_are_named_with_their_place(self):
        self.refused("/runs/0/expct", "did you mean 'expect'", expct=[])
        self.refused("/runs/0/model", "plan.json", model="plan.json")
        self.refused("/runs/0/set/controller.stifness", "did you mean 'stiffness'", set={"controller.stifness": 1})
        self.refused("/runs/0/set/controller.stiffness", "a mass [kg]", set={"controller.stiffness": "3 kg"})
        self.refused("/runs/0/vary/mechanics.mas", "did you mean 'mass'", vary={"mechanics.mas": [1]})
        self.refused("/runs/0/command", "did you mean 'passivity'", command="pasivity")

    def test_what_is_no_study_and_a_broken_baseline_are_refused(self):
        self.assert_refused(self.run_program("study", "check", "plant.json"), "plant.json", "gyrator/regression/1")
        self.assert_refused(self.run_program("study", "check", "study.jsn"), "study.jsn")
        self.assert_refused(self.run_program("study", "check", "study.json", "./study.json"), "given twice")
        (self.folder / "study.baseline.json").write_text('{"schema": "gyrator/baseline/1", "study": "Wall"}')
        self.assert_refused(self.run_program("study", "check", "study.json"), "study.baseline.json", "'runs'")

    def test_a_figure_that_is_not_there_names_the_nearest(self):
        run = dict(STUDY["runs"][0], expect=[{"figure": "verdit", "equals": "passive"}])
        self.write_study(dict(STUDY, runs=[run]))
        self.assertIn("did you mean 'verdict'", self.failed()[("limit", "verdit")])


class InterruptTest(StudyTest):

    def test_ctrl_c_ends_the_children_and_leaves_nothing(self):
        run = {"name": "long", "command": "simulate", "model": "plant.json", "set": {"simulation.duration": "4000 s"},
               "vary": {"controller.stiffness": [100, 200, 300]}}
        self.write_study(dict(STUDY, runs=[run]))
        scratch = self.folder / "tmp"
        scratch.mkdir()
        before = self.files()
        os.environ["TMPDIR"] = str(scratch)
        self.addCleanup(os.environ.pop, "TMPDIR")
        for command in (("update", "study.json", "--yes"), ("run", "study.json", "-o", "out")):
            answer = self.interrupt("study", *command, after_s=0.7, within_s=2.0)
            self.assertEqual(answer.code, 130, answer)
            self.assertIn("interrupted", answer.err)
            self.assertEqual(self.files(), before)
            self.assertEqual(list(scratch.iterdir()), [])
            self.assertNotIn(str(self.folder).encode(), self.processes())

    def processes(self):
        return subprocess.run(["ps", "-eo", "args"], capture_output=True).stdout if shutil.which("ps") else b""


class ThreadsTest(StudyTest):

    def count_threads(self, limit):
        process = subprocess.Popen([program(), "tolerance", EXAMPLES / "rc_display_tolerance.json", "--quiet"],
                                   cwd=self.folder, env=NEITHER_CI | {"GYRATOR_THREADS": str(limit)},
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        most = 0
        end = time.monotonic() + (2 if limit == 1 else PATIENCE_S)
        while most < 2 and process.poll() is None and time.monotonic() < end:
            try:
                most = max(most, len(os.listdir(f"/proc/{process.pid}/task")))
            except FileNotFoundError:
                break
            time.sleep(0.02)
        process.kill()
        process.wait()
        return most

    @unittest.skipUnless(os.path.exists("/proc/self/task") and (os.cpu_count() or 1) > 1, "needs /proc and two cores")
    def test_the_environment_limits_the_threads_of_a_child(self):
        self.assertEqual(self.count_threads(1), 1)
        self.assertEqual(self.count_threads(2), 2)


class ShippedTest(StudyTest):

    def test_the_shipped_schema_is_the_programs(self):
        self.assertEqual(self.run_program("schema", "--regression").out,
                         (ROOT / "schemas/regression.schema.json").read_text())

    def test_the_manual_has_the_programs_table(self):
        table = self.run_program("schema", "--regression", "--manual").out
        self.assertIn(table.strip(), (ROOT / "docs/studies.md").read_text())

    def test_the_repository_has_studies_and_their_pages_links(self):
        self.assertTrue(STUDIES)
        for study in STUDIES:
            self.assertTrue((study.parent / "study.baseline.json").exists(), study)


if __name__ == "__main__":
    unittest.main()
