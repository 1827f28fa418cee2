"""Files that a command writes: whole or not at all, also when the user presses Ctrl-C."""
import json
import os
import re
import stat
import unittest

from program import EXAMPLES, MODEL_COMMANDS, RC_DISPLAY, ProgramTest, load_example, with_value

ENDLESS = {  # commands that would work for minutes
    "simulate, exact": ["simulate", RC_DISPLAY, "--duration", "2e4 s"],
    "simulate, cvode": ["simulate", RC_DISPLAY, "--duration", "1e4 s", "--engine", "cvode"],
    "simulate, odeint": ["simulate", RC_DISPLAY, "--duration", "1e4 s", "--engine", "odeint"],
    "simulate, trace step": ["simulate", RC_DISPLAY, "--duration", "100 s", "--trace-step", "20 us"],
}


class OutputTest(ProgramTest):

    def test_a_path_that_cannot_be_written_is_refused_and_leaves_nothing(self):
        self.write_model(load_example())
        for option, ending in (("-o", "json"), ("--csv", "csv"), ("--svg", "svg"), ("--png", "png")):
            for place in ("missing/out.", "model.json/out."):  # no such folder; a file is no folder
                answer = self.run_program("impedance", "model.json", "--points", "5", option, place + ending)
                with self.subTest(option=option, place=place):
                    self.assert_refused(answer, place + ending, "cannot be written")
                    self.assertEqual(self.files(), ["model.json"])

    def test_a_folder_is_not_written_over(self):
        (self.folder / "out.csv").mkdir()
        for arguments in (["impedance", RC_DISPLAY, "--csv", "out.csv"], ["impedance", RC_DISPLAY, "-o", "out.csv"]):
            self.assert_refused(self.run_program(*arguments), "out.csv", "directory")
        self.assertEqual(self.files(), ["out.csv"])

    def test_a_path_that_cannot_be_written_is_told_before_the_work(self):
        answer = self.run_program("zwidth", RC_DISPLAY, "--points", "300000", "-o", "missing/out.json", timeout=2.5)
        self.assert_refused(answer, "missing/out.json")

    def test_a_plot_of_another_type_is_refused_by_its_ending(self):
        for option, name, ending in (("--svg", "z.png", ".svg"), ("--png", "z.svg", ".png"),
                                     ("--png", "z.pdf", ".png"), ("--svg", "z", ".svg")):
            for command in MODEL_COMMANDS:
                answer = self.run_program(command, RC_DISPLAY, option, name)
                with self.subTest(command=command, option=option, name=name):
                    self.assert_refused(answer, option, name, f"must end in {ending}")
        self.assertEqual(self.files(), [])

    def test_a_disk_that_is_full_is_an_error(self):
        for option in ("-o", "--csv"):
            self.assert_refused(self.run_program("impedance", RC_DISPLAY, "--quiet", option, "/dev/full"), "/dev/full")

    def test_a_stdout_that_is_full_is_an_error(self):
        for arguments in (["impedance", RC_DISPLAY], ["impedance", RC_DISPLAY, "--json"], ["schema"]):
            with open("/dev/full", "wb") as full:
                answer = self.run_program(*arguments, stdout=full)
            with self.subTest(arguments=arguments):
                self.assert_refused(answer, "cannot be written")

    def test_a_missing_gnuplot_is_named_and_leaves_no_plot(self):
        answer = self.run_program("impedance", RC_DISPLAY, "--svg", "z.svg",
                                  environment={**os.environ, "PATH": str(self.folder)})
        self.assert_refused(answer, "gnuplot", "not installed")
        self.assertEqual(self.files(), [])

    def test_a_model_is_never_written_over_by_its_own_result(self):
        for option in ("-o", "--csv"):
            name = self.write_model(load_example())
            before = (self.folder / name).read_text()
            answer = self.run_program("impedance", name, "--points", "5", option, name)
            with self.subTest(option=option):
                self.assertEqual((self.folder / name).read_text(), before)
                self.assert_refused(answer, name)

    def test_two_outputs_of_one_name_are_refused(self):
        answer = self.run_program("impedance", RC_DISPLAY, "--points", "5", "--csv", "out", "-o", "out")
        self.assert_refused(answer, "out")

    def test_a_run_that_fails_leaves_what_it_had_and_says_where(self):
        (self.folder / "trace.csv").write_text("the last run\n")
        answer = self.run_program("simulate", RC_DISPLAY, "--engine", "cvode", "--max-steps", "1", "--csv",
                                  "trace.csv", "-o", "result.json", "--svg", "run.svg")
        self.assert_refused(answer, "engine gave up", "the run up to t = 0 s is in trace.csv, run.svg, "
                            "result.json", code=3)
        header, row = (self.folder / "trace.csv").read_text().splitlines()
        self.assertTrue(header.startswith("time_s,position,velocity,effort,command,"))
        self.assertEqual(row.count(","), header.count(","))
        self.assertEqual(float(row.split(",")[0]), 0)
        result = json.loads((self.folder / "result.json").read_text())
        self.assertEqual(result["failure"]["exit_code"], 3)
        self.assertIn("engine gave up", result["failure"]["message"])
        self.assertIsNone(result["classification"])
        self.assertEqual(self.run_program("report", "result.json", "-o", "report.html").code, 0)
        self.assertIn("engine gave up", (self.folder / "report.html").read_text())

    def test_a_run_that_cannot_begin_keeps_the_file_of_the_last_one(self):
        (self.folder / "trace.csv").write_text("the last run\n")
        answer = self.run_program("simulate", RC_DISPLAY, "--duration", "1 us", "--csv", "trace.csv")
        self.assertEqual(answer.code, 2, answer)
        self.assertEqual((self.folder / "trace.csv").read_text(), "the last run\n")
        self.assertEqual(self.files(), ["trace.csv"])

    def test_a_new_result_replaces_the_old_and_keeps_its_permissions(self):
        kept = self.folder / "result.json"
        kept.write_text("old " * 100000)
        kept.chmod(0o640)
        self.ask("impedance", RC_DISPLAY, "--points", "5", "-o", "result.json")
        self.assertTrue(kept.read_text().startswith("{"))
        self.assertEqual(stat.S_IMODE(kept.stat().st_mode), 0o640)
        self.assertEqual(self.files(), ["result.json"])

    def test_a_link_stays_a_link(self):
        (self.folder / "kept.csv").write_text("old")
        (self.folder / "latest.csv").symlink_to("kept.csv")
        self.ask("impedance", RC_DISPLAY, "--points", "5", "--csv", "latest.csv")
        self.assertTrue((self.folder / "latest.csv").is_symlink())
        self.assertIn("frequency_hz", (self.folder / "kept.csv").read_text())

    def test_a_reader_that_leaves_early_leaves_no_complaint_behind(self):
        read, write = os.pipe()
        os.close(read)
        with os.fdopen(write, "wb") as pipe:
            answer = self.run_program("impedance", RC_DISPLAY, "--points", "20000", "--json", stdout=pipe)
        self.assertNotIn("internal error", answer.err)
        self.assertNotEqual(answer.code, 0)

    def test_a_report_that_cannot_be_written_is_refused_and_leaves_nothing(self):
        self.run_program("impedance", RC_DISPLAY, "--points", "5", "-o", "z.json", "--quiet")
        self.assert_refused(self.run_program("report", "z.json", "-o", "missing/r.html"), "missing/r.html",
                            "cannot be written")
        self.assert_refused(self.run_program("report", "z.json", "--finding", "f.pdf", "-o", "r.html"), "f.pdf",
                            ".svg or .png")
        self.assert_refused(self.run_program("report", "z.json", "--figures", "z.json", "-o", "r.html"), "z.json",
                            "is no folder")
        self.assertEqual(self.files(), ["z.json"])

    def test_the_figures_of_a_report_are_written_as_svg_files(self):
        self.run_program("impedance", RC_DISPLAY, "--points", "5", "-o", "z.json", "--quiet")
        answer = self.run_program("report", "z.json", "-o", "r.html", "--figures", "new/figures")
        self.assertEqual((answer.code, answer.err), (0, ""), answer)
        drawn = {path.name: path.read_text() for path in (self.folder / "new/figures").iterdir()}
        self.assertEqual(sorted(drawn), ["1-impedance.svg", "device.svg"])
        self.run_program("impedance", RC_DISPLAY, "--points", "5", "--svg", "z.svg", "--quiet")
        self.assertEqual(drawn["1-impedance.svg"], (self.folder / "z.svg").read_text())


class InterruptTest(ProgramTest):
    """Ctrl-C: exit 130 within a second, and no half-written file."""

    def press(self, arguments, after_s=0.4):
        (self.folder / "old.csv").write_text("the last run\n")
        answer = self.interrupt(*arguments, "--csv", "old.csv", "-o", "new.json", after_s=after_s)
        self.assertEqual(answer.code, 130, answer)
        self.assertEqual(answer.out, "")
        self.assertIn("interrupted", answer.err)
        self.assertEqual((self.folder / "old.csv").read_text(), "the last run\n")
        self.assertEqual(self.files(), ["old.csv"])
        return answer

    def test_a_simulation_stops_and_says_how_far_it_came(self):
        for title, arguments in ENDLESS.items():
            with self.subTest(title):
                answer = self.interrupt(*arguments, after_s=0.4)
                self.assertEqual((answer.code, answer.out), (130, ""), answer)
                self.assertRegex(answer.err, r"t = [0-9.e+-]+ s: interrupted")

    def test_an_interrupted_simulation_keeps_its_trace_up_to_there(self):
        for title, arguments in ENDLESS.items():
            (self.folder / "trace.csv").write_text("the last run\n")
            # Writing what has been simulated takes its time, on a busy machine and with sanitizers.
            answer = self.interrupt(*arguments, "--csv", "trace.csv", "-o", "run.json", after_s=0.2, within_s=60)
            with self.subTest(title):
                self.assertEqual((answer.code, answer.out), (130, ""), answer)
                told = re.search(r"t = [0-9.e+-]+ s: interrupted; the run up to t = ([0-9.e+-]+) s is in "
                                 r"trace.csv, run.json\n", answer.err)
                self.assertTrue(told, answer)
                header, *rows = (self.folder / "trace.csv").read_text().splitlines()
                columns = header.split(",")
                self.assertTrue(rows and all(len(row.split(",")) == len(columns) for row in rows))
                times = [float(row.split(",", 1)[0]) for row in rows]
                self.assertEqual(times, sorted(times))
                self.assertEqual(f"{times[-1]:g}", told.group(1))
                result = json.loads((self.folder / "run.json").read_text())
                self.assertEqual(result["failure"]["exit_code"], 130)
                energy = result["energy"]
                moved = abs(energy["operator"]) + abs(energy["source"]) + energy["dissipated"]
                self.assertLess(abs(energy["residual"]), 1e-6 * (moved + energy["stored_initially"]))
                self.assertEqual(self.files(), ["run.json", "trace.csv"])

    def test_a_large_zwidth_stops(self):
        self.press(["zwidth", RC_DISPLAY, "--points", "300000"])

    def test_a_large_zwidth_of_coupled_loops_stops(self):
        self.press(["zwidth", EXAMPLES / "re35_rc_display.json", "--criterion", "coupled", "--from", "0", "--to",
                    "1e-3", "--points", "300000"])

    def test_a_large_impedance_stops(self):
        self.press(["impedance", RC_DISPLAY, "--points", "1000000"])

    def test_a_verdict_over_a_delay_of_a_thousand_samples_is_quick_or_stops(self):
        name = self.write_model(with_value(load_example(), "/sampling/delay", "1 s"))
        answer = self.interrupt("passivity", name, "-o", "new.json", may_be_over=True)
        self.assertIn(answer.code, (0, 1, 2, 130), answer)
        self.assertEqual(self.files(), [name, "new.json"] if answer.code < 2 else [name])


if __name__ == "__main__":
    unittest.main()
