"""Z-width over frequency, nonlinear environments and the joints of a mechanism, as a user asks for them."""
import csv
import json
import math
import unittest

from program import EXAMPLES, RC_DISPLAY, ProgramTest, load_example

P3 = EXAMPLES / "p3_plant.json"
CLICK = EXAMPLES / "environments" / "click.csv"
ARM = EXAMPLES / "environments" / "two_link_arm.json"


class EnvelopeTest(ProgramTest):

    def test_the_envelope_is_one_object_of_columns_around_the_bare_device(self):
        answer = self.run_program("zwidth", RC_DISPLAY, "--envelope", "--json", "--csv", "out.csv")
        self.assertEqual((answer.code, answer.err), (0, ""), answer)
        result = answer.json
        self.assertEqual(result["command"], "zwidth-envelope")
        self.assertEqual(result["criterion"], "exact_disk")
        self.assertEqual(result["frequency_hz"][0], 1)
        self.assertLess(result["frequency_hz"][-1], 500)
        for low, bare, high, most, least in zip(*(result[key] for key in (
                "impedance_min", "bare_impedance", "impedance_max", "admittance_max", "admittance_min"))):
            self.assertLessEqual(low, bare * (1 + 1e-9))
            self.assertLessEqual(bare, high * (1 + 1e-9))
            self.assertAlmostEqual(low * most, 1, places=12)
            self.assertAlmostEqual(high * least, 1, places=12)
        # The stiffest wall that README tells about, at B = 1.5e-4, is inside.
        at_one_hz = result["impedance_max"][0]
        self.assertGreater(at_one_hz, 0.0657 / (2 * math.pi))
        with open(self.folder / "out.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), len(result["frequency_hz"]))
        self.assertEqual(float(rows[3]["stiffness_at_impedance_max"]), result["at_impedance_max"]["stiffness"][3])

    def test_more_cut_offs_only_widen_the_envelope(self):
        areas = []
        for cutoffs in ("50", "50,200"):
            result = self.ask("zwidth", RC_DISPLAY, "--envelope", "--cutoff", cutoffs, "--band", "1,100")
            areas.append(result["areas"]["logarithmic"])
            self.assertEqual(len(result["regions"]), len(cutoffs.split(",")))
            self.assertTrue(set(result["at_impedance_max"]["cutoff_hz"]) <= {50, 200})
        self.assertGreaterEqual(areas[1], areas[0])

    def test_it_goes_into_a_report_and_a_figure(self):
        self.run_program("zwidth", P3, "--envelope", "-o", "envelope.json", "--quiet", "--svg", "envelope.svg")
        self.assertIn("bare device", (self.folder / "envelope.svg").read_text())
        self.run_program("environment", CLICK, "--model", P3, "-o", "environment.json", "--quiet")
        self.run_program("workspace", ARM, "-o", "workspace.json", "--quiet")
        answer = self.run_program("report", "envelope.json", "environment.json", "workspace.json", "-o", "report.html")
        self.assertEqual((answer.code, answer.err), (0, ""), answer)
        page = (self.folder / "report.html").read_text()
        for words in ("Z-width over frequency", "Nonlinear environment", "Joint damping at the hand"):
            self.assertIn(words, page)

    def test_a_criterion_that_calls_too_much_passive_shows_itself(self):
        answer = self.run_program("zwidth", RC_DISPLAY, "--envelope", "--criterion", "frequency_dependent")
        self.assertEqual(answer.code, 0)
        self.assertIn("frequency_dependent is mistaken here", answer.out)

    def test_the_text_has_units_and_says_what_the_criterion_asks_for(self):
        text = self.run_program("zwidth", RC_DISPLAY, "--envelope", "--band", "1,10", "--cutoff", "50").out
        self.assertIn("walls that exact_disk calls passive", text)
        self.assertIn("K [N.m/rad] and B [N.m.s/rad], cut-off [Hz]", text)
        text = self.run_program("zwidth", RC_DISPLAY, "--envelope", "--band", "1,10", "--criterion", "coupled").out
        self.assertIn("that are stable with the model's operator (coupled)", text)
        self.assertNotIn("calls passive", text)

    def test_what_is_there_twice_is_refused(self):
        for option, value, words in (("--damping", "0, 1e-4, 0.1 mN.m.s/rad", "0.1 mN.m.s/rad: is there twice"),
                                     ("--criterion", "exact_disk,exact_disk", "exact_disk: is there twice")):
            self.assert_refused(self.run_program("zwidth", RC_DISPLAY, option, value), option, words)

    def test_what_has_no_envelope_is_refused_in_words(self):
        for arguments, words in (
                ((RC_DISPLAY, "--envelope", "--criterion", "exact_disk,coupled"), "by one criterion"),
                ((RC_DISPLAY, "--envelope", "--band", "1,900"), "gyrator: --band: 1 Hz to 900 Hz"),
                ((RC_DISPLAY, "--envelope", "--band", "10"), "two frequencies"),
                ((RC_DISPLAY, "--envelope", "--cutoff", "-3"), "must be above 0 Hz"),
                ((RC_DISPLAY, "--cutoff", "3"), "--envelope"),
                ((RC_DISPLAY, "--envelope", "--damping", "0"), "--damping"),
                ((EXAMPLES / "wave_display.json", "--envelope"), "behind a wave line")):
            with self.subTest(words=words):
                self.assert_refused(self.run_program("zwidth", *arguments), words)


class EnvironmentTest(ProgramTest):

    def write_spring(self, stiffness):
        (self.folder / "spring.csv").write_text(f"position,effort\n-1,{-stiffness}\n1,{stiffness}\n")

    def test_a_spring_is_passive_up_to_two_b_over_t(self):
        damping = load_example("p3_plant")["mechanics"]["damping"]
        limit = 2 * float(str(damping).split()[0]) / 1e-3
        for factor, code in ((0.999, 0), (1.001, 1)):
            self.write_spring(factor * limit)
            answer = self.run_program("environment", "spring.csv", "--model", P3)
            self.assertEqual(answer.code, code, answer)
        answer = self.run_program("environment", "spring.csv", "--model", P3, "--coupling-damping", "1 N.s/m")
        self.assertIn("delta gamma/(delta + gamma)", answer.out)
        self.assertEqual(answer.code, 1)

    def test_a_device_with_another_path_is_not_called_passive(self):
        self.write_spring(1e-6)
        answer = self.run_program("environment", "spring.csv", "--model", RC_DISPLAY)
        self.assertEqual(answer.code, 1)
        self.assertIn("A is not 1", answer.out)

    def test_what_is_no_profile_is_refused_with_its_line(self):
        (self.folder / "back.csv").write_text("position,effort\n0,0\n1,1\n0.5,2\n")
        self.assert_refused(self.run_program("environment", "back.csv", "--model", P3), "back.csv:4", "must increase")
        (self.folder / "short.csv").write_text("position,effort\n0,0\n")
        self.assert_refused(self.run_program("environment", "short.csv", "--model", P3), "at least two")
        (self.folder / "names.csv").write_text("x,effort\n0,0\n1,1\n")
        self.assert_refused(self.run_program("environment", "names.csv", "--model", P3), "names.csv:1",
                            "no column 'position': there are: x, effort; needed: position, effort")
        self.assert_refused(self.run_program("environment", CLICK), "--model")
        self.assert_refused(
            self.run_program("environment", CLICK, "--model", P3, "--coupling-damping", "0"), "must be above 0")


class WorkspaceTest(ProgramTest):

    def test_the_arm_has_its_least_damping_outstretched(self):
        answer = self.run_program("workspace", ARM, "--json", "--csv", "poses.csv")
        self.assertEqual(answer.code, 1)
        result = answer.json
        self.assertEqual((result["verdict"], result["worst_pose"]), ("not_enough", "outstretched"))
        # One direction: 1/(0.4^2/0.05 + 0.2^2/0.03)
        self.assertAlmostEqual(result["largest_isotropic"], 1 / (0.16 / 0.05 + 0.04 / 0.03), places=12)
        arm = json.loads(ARM.read_text())
        arm["task_damping"] = result["largest_isotropic"] * 0.999
        self.assertEqual(self.run_program("workspace", self.write_model(arm)).code, 0)
        del arm["task_damping"]
        answer = self.run_program("workspace", self.write_model(arm))
        self.assertEqual(answer.code, 0)
        self.assertNotIn("wanted", answer.out)
        self.assertIn("largest isotropic [SI]", answer.out)
        self.assertIn(" N.s/m (about an axis: N.m.s/rad)", answer.out)

    def test_poses_have_their_names_below_the_figure(self):
        self.run_program("workspace", ARM, "--svg", "arm.svg", "--quiet")
        self.assertIn("elbow 90 deg", (self.folder / "arm.svg").read_text())

    def test_what_is_no_workspace_is_refused_with_its_place(self):
        arm = json.loads(ARM.read_text())
        for key, value, words in (("joint_damping", ["1 mN.m.s/rad"], "1 damping for 2 joints"),
                                  ("joint_damping", ["1 N.m", 1], "/joint_damping/0"),
                                  ("joint_damping", [0, 1], "above 0"),
                                  ("task_damping", [[1, 0.5], [0, 1]], "symmetric"),
                                  ("joint_dampin", 1, "joint_damping"),
                                  ("poses", [{"jacobian": [[1, 2], [3]]}], "/poses/0/jacobian/1"),
                                  ("poses", [{"jacobian": 3}], "a matrix is expected")):
            with self.subTest(words=words):
                self.assert_refused(self.run_program("workspace", self.write_model({**arm, key: value})), words)


if __name__ == "__main__":
    unittest.main()
