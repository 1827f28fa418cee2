"""gyrator tolerance: what a user types, and what comes out."""
import csv
import json

from program import EXAMPLES, ProgramTest, RC_DISPLAY

EXAMPLE = EXAMPLES / "rc_display_tolerance.json"


def plant(damping="1 mN.m.s/rad ± 20 %", stiffness=1.0, **more):
    """An inertia and a damper under an ideal drive: K_max = 2 b/T."""
    return {"name": "P", "motion": "rotary", "mechanics": {"inertia": 2e-5, "damping": damping},
            "amplifier": {"kind": "ideal"}, "sampling": {"period": "1 ms"},
            "controller": {"kind": "virtual_wall", "stiffness": stiffness}, **more}


class ToleranceTest(ProgramTest):

    def test_exit_code_says_whether_every_choice_of_parts_is_passive(self):
        for stiffness, code, words in ((1.59, 0, "PASSIVE in every sample"), (1.61, 1, "NOT PASSIVE"),
                                       (5.0, 1, "NOT PASSIVE")):
            model = self.write_model(plant(stiffness=stiffness))
            answer = self.run_program("tolerance", model, "--samples", 50)
            with self.subTest(stiffness=stiffness):
                self.assertEqual((answer.code, answer.err), (code, ""), answer)
                self.assertIn("P: " + words, answer.out)
                self.assertIn("mechanics.damping", answer.out)
                self.assertIn("; 1 part with a tolerance\n", answer.out)
        self.assertIn("\n1 sample (uniform", self.run_program("tolerance", model, "--samples", 1).out)

    def test_a_guarantee_is_a_proof_or_parts_that_are_not_passive(self):
        for stiffness, code, words in ((1.59, 0, "guaranteed: PASSIVE with every choice of parts"),
                                       (1.61, 1, "guaranteed: NOT PASSIVE")):
            model = self.write_model(plant(stiffness=stiffness))
            answer = self.run_program("tolerance", model, "--samples", 5, "--guarantee")
            with self.subTest(stiffness=stiffness):
                self.assertEqual((answer.code, answer.err), (code, ""), answer)
                self.assertIn(words, answer.out)
        guaranteed = self.ask("tolerance", model, "--samples", 5, "--guarantee")["guaranteed"]
        self.assertEqual(guaranteed["verdict"], "not_passive")
        self.assertAlmostEqual(guaranteed["at"]["mechanics.damping"], 0.8e-3, places=9)
        self.assertLess(guaranteed["margin"], 0)
        self.assertGreater(guaranteed["frequency_hz"], 0)

    def test_the_parts_of_the_figure_have_their_names(self):
        self.run_program("tolerance", EXAMPLE, "--samples", 5, "--svg", "t.svg", "--quiet")
        figure = (self.folder / "t.svg").read_text()
        self.assertIn(">motor.temperature_rise<", figure)

    def test_a_guarantee_that_runs_out_of_its_budget_says_so(self):
        # So near the limit of 1.6 that one box is too wide.
        model = self.write_model(plant(stiffness=1.5999))
        result = self.ask("tolerance", model, "--samples", 5, "--guarantee", "--guarantee-boxes", 1)
        self.assertEqual(result["guaranteed"]["verdict"], "undecided")
        self.assertIn("budget", result["guaranteed"]["reason"])
        self.assertEqual(result["guaranteed"]["boxes"], 1)
        refused = self.run_program("tolerance", model, "--guarantee-time", 0)
        self.assertEqual(refused.code, 2, refused)

    def test_json_has_limits_yield_and_parts(self):
        model = self.write_model(plant(stiffness=2.0))
        result = self.ask("tolerance", model, "--samples", 200, "--seed", 3)
        self.assertAlmostEqual(result["nominal"]["max_stiffness"], 2.0, places=5)
        self.assertAlmostEqual(result["worst"]["max_stiffness"], 1.6, places=5)
        self.assertFalse(result["worst"]["passive"])
        self.assertLess(result["worst"]["margin"], 0)
        samples = result["samples"]
        self.assertEqual(sum(samples["outcomes"].values()), 200)
        self.assertAlmostEqual(samples["yield"], samples["outcomes"]["passive"] / 200)
        self.assertLess(samples["yield_low"], samples["yield"])
        self.assertLess(samples["yield"], samples["yield_high"])
        self.assertEqual(sum(samples["histogram"]["count"]), 200)
        part, = result["parts"]
        self.assertEqual((part["pointer"], part["written"]), ("/mechanics/damping", "1 mN.m.s/rad ± 20 %"))
        self.assertAlmostEqual(part["worst"], 0.8e-3, places=9)
        self.assertAlmostEqual(part["elasticity"], 1, places=3)

    def test_csv_has_one_row_per_sample_that_gives_its_limit(self):
        model = self.write_model(plant(stiffness=2.0))
        self.run_program("tolerance", model, "--samples", 40, "--csv", "s.csv")
        with open(self.folder / "s.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 40)
        for row in rows:
            limit = float(row["max_stiffness"])
            self.assertAlmostEqual(limit, 2 * float(row["mechanics.damping"]) / 1e-3, places=5)
            self.assertEqual(row["outcome"], "0" if limit > 2 else "1")

    def test_seed_decides_and_threads_do_not(self):
        model = self.write_model(plant())
        answers = []
        for options in (["--threads", 1], ["--threads", 3], ["--seed", 2]):
            result = self.ask("tolerance", model, "--samples", 60, *options)
            del result["command_line"]
            answers.append(result["samples"])
        self.assertEqual(answers[0], answers[1])
        self.assertNotEqual(answers[0]["mean"], answers[2]["mean"])

    def test_plots_and_report_show_the_example(self):
        answer = self.run_program("tolerance", EXAMPLE, "--samples", 100, "--svg", "t.svg", "--png", "t.png",
                                  "-o", "t.json")
        self.assertEqual((answer.code, answer.err), (1, ""), answer)
        svg = (self.folder / "t.svg").read_text()
        for words in ("worst case found", "rc.capacitance", "motor.torque_constant"):
            self.assertIn(words, svg)
        self.assertEqual(json.loads((self.folder / "t.json").read_text())["command"], "tolerance")
        report = self.run_program("report", "t.json", "-o", "t.html")
        self.assertEqual((report.code, report.err), (0, ""), report)
        page = (self.folder / "t.html").read_text()
        self.assertIn("Tolerances of parts", page)
        self.assertIn("not passive at the worst case found", page)

    def test_ctrl_c_leaves_nothing_behind(self):
        answer = self.interrupt("tolerance", EXAMPLE, "--samples", 1000000, "--csv", "s.csv", "--svg", "s.svg",
                                after_s=1)
        self.assertEqual(answer.code, 130, answer)
        self.assertEqual(self.files(), [])

    def test_what_it_cannot_take_is_named(self):
        for options in ((), ("--guarantee",)):
            answer = self.run_program("tolerance", RC_DISPLAY, *options)
            self.assert_refused(answer, f"{RC_DISPLAY}: /: no quantity has a tolerance", '"5 ohm ± 5 %"')
            self.assertEqual(answer.err.count(str(RC_DISPLAY)), 1)
        for text, words in (("1 mN.m.s/rad ± 120 %", "at its low end -"), ("1 mN.m.s/rad ± 5", "of what?"),
                            ("1 mN.m.s/rad +5 %", "to one side"), ("1 mN.m.s/rad ± 1 ohm", "this is a resistance")):
            model = self.write_model(plant(text))
            with self.subTest(text=text):
                self.assert_refused(self.run_program("tolerance", model), "/mechanics/damping", words)
        model = self.write_model(plant(stiffness="1 N.m/rad ± 5 %"))
        self.assert_refused(self.run_program("passivity", model), "/controller/stiffness",
                            "no tolerance is possible here")
        model = self.write_model(plant())
        self.assert_refused(self.run_program("tolerance", model, "--distribution", "gauss"), "--distribution",
                            "uniform")

    def test_other_commands_take_the_nominal_values(self):
        toleranced, plain = plant(stiffness=1.0), plant("1 mN.m.s/rad", stiffness=1.0)
        self.write_model(toleranced, "a.json")
        self.write_model(plain, "b.json")
        limits = [self.ask("zwidth", name, "--damping", "0")["max_stiffness"] for name in ("a.json", "b.json")]
        self.assertEqual(limits[0], limits[1])
        words = "at the nominal values of 1 part with a tolerance: `gyrator tolerance` varies it."
        (self.folder / "spring.csv").write_text("position,effort\n-1,-1\n1,1\n")
        for command in (("passivity",), ("zwidth",), ("simulate",), ("impedance",), ("zwidth", "--envelope"),
                        ("environment", "spring.csv", "--model")):
            with self.subTest(command=command):
                self.assertIn(words, self.run_program(*command, "a.json").out)
                self.assertNotIn(words, self.run_program(*command, "b.json").out)
        coupling = {"kind": "virtual_coupling", "coupling": {"stiffness": 0.1}, "tool": {"inertia": 1e-5}}
        self.write_model({**toleranced, "controller": coupling}, "c.json")
        self.assertIn(words, self.run_program("twoport", "c.json").out)
