"""`gyrator compare`: designs side by side say what the other commands say of each."""

import copy
import json
import subprocess
import unittest

from program import EXAMPLES, ROOT, ProgramTest, program

RE25 = {
    "schema": "gyrator/model/1", "name": "cancelled", "motion": "rotary",
    "motor": {"torque_constant": "23.5 mN.m/A", "resistance": "2.06 ohm", "inductance": "0.238 mH"},
    "mechanics": {"inertia": 1.07e-6, "damping": 1.2e-6},
    "amplifier": {"kind": "voltage"},
    "damping": [{"kind": "resistance_cancellation", "fraction": 0.9}],
    "sampling": {"period": "1 ms"},
    "controller": {"kind": "virtual_wall", "stiffness": 0.1, "damping": 0},
}


class CompareTest(ProgramTest):
    def compare(self, *arguments):
        return self.ask("compare", *arguments)

    def test_limits_and_feel_are_those_of_zwidth_and_impedance(self):
        paths = [EXAMPLES / "re25_display.json", EXAMPLES / "re25_rc_display.json"]
        result = self.compare(*paths, "--damping", "0,1e-6,2e-4")
        self.assertEqual(len(result["designs"]), 2)
        for path, design in zip(paths, result["designs"]):
            zwidth = self.ask("zwidth", path, "--damping", "0,1e-6,2e-4", "--criterion", "exact_disk")
            self.assertEqual(design["max_stiffness"], zwidth["max_stiffness"])
            self.assertEqual(design["feasible"], zwidth["feasible"])
            z = self.ask("impedance", path, "--frequency", "1,100")
            self.assertEqual(design["damping_1hz"], z["impedance_real"][0])
            self.assertEqual(design["damping_100hz"], z["impedance_real"][1])
            self.assertAlmostEqual(design["apparent_inertia"] * 2 * 3.141592653589793,
                                   z["impedance_imag"][0], delta=1e-12 * z["impedance_imag"][0])

    def test_a_winding_colder_and_warmer_is_the_model_at_that_rise(self):
        model = self.write_model(RE25)
        design = self.compare(model, "--damping", "0", "--temperature-step", "10 K")["designs"][0]
        for key, rise in (("colder", -10), ("warmer", 10)):
            other = copy.deepcopy(RE25)
            other["motor"]["temperature_rise"] = rise
            path = self.write_model(other, key + ".json")
            zwidth = self.ask("zwidth", path, "--damping", "0", "--criterion", "exact_disk")
            self.assertEqual(design[key]["temperature_rise"], rise)
            self.assertEqual(design[key]["max_stiffness"], zwidth["max_stiffness"][0])
        self.assertGreater(design["colder"]["damping_100hz"], design["warmer"]["damping_100hz"])

    def test_a_design_that_oscillates_when_cold_is_said_to(self):
        model = self.write_model(RE25)  # 90 % cancelled: the edge lies 25.4 K below
        result = self.compare(model, "--damping", "0", "--temperature-step", "26 K")
        self.assertFalse(result["designs"][0]["colder"]["stable"])
        self.assertTrue(result["designs"][0]["warmer"]["stable"])
        text = self.run_program("compare", model, "--damping", "0", "--temperature-step", "26 K")
        self.assertIn("unstable", text.out)

    def test_each_design_is_shown_to_where_its_boundary_ends(self):
        design = self.compare(EXAMPLES / "re25_rc_display.json", "--points", "20")["designs"][0]
        self.assertEqual(design["damping"][0], 0)
        self.assertTrue(all(design["feasible"]))
        end = design["damping"][-1]
        beyond = self.ask("zwidth", EXAMPLES / "re25_rc_display.json", "--criterion", "exact_disk",
                               "--damping", f"{end},{1.001 * end}")
        self.assertEqual(beyond["feasible"], [True, False])

    def test_designs_of_different_motion_are_refused_by_name(self):
        self.assert_refused(
            self.run_program("compare", EXAMPLES / "re25_display.json", EXAMPLES / "p3_plant.json"),
            "p3_plant.json: /motion")

    def test_the_study_of_dampings_gives_what_the_readme_says(self):
        kinds = ("none", "resistor", "rc", "cancellation", "back_emf", "wave", "held_impedance")
        models = [EXAMPLES / "compare" / f"re25_{kind}.json" for kind in kinds]
        found = [d["max_stiffness"][0] for d in self.compare(*models, "--damping", "0")["designs"]]
        table = (ROOT / "README.md").read_text().split("| RE25, T = 1 ms |")[1].split("\n\n")[0]
        printed = [row.split("|")[2].strip() for row in table.splitlines()[2:]]
        self.assertEqual(len(printed), len(kinds))
        for text, stiffness in zip(printed, found):
            if text == "no limit":
                self.assertIsNone(stiffness)
                continue
            number, unit = text.split()
            scale = {"N·m/rad": 1, "mN·m/rad": 1e-3}[unit]
            last_digit = 10 ** -len(number.partition(".")[2])
            self.assertAlmostEqual(stiffness / scale, float(number), delta=0.51 * last_digit)

    def test_the_study_script_leaves_pictures_and_a_report(self):
        done = subprocess.run([str(EXAMPLES / "compare-dampings"), program(), str(self.folder / "out")],
                              capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("RE35, wave drive", done.stdout)
        self.assertLessEqual({"compare.html", "compare_re25.svg", "compare_re35.csv"},
                             {path.name for path in (self.folder / "out").iterdir()})

    def test_the_picture_and_the_report_show_every_design(self):
        folder = self.folder
        picture = folder / "compared.svg"
        result = folder / "compared.json"
        self.run_program("compare", EXAMPLES / "re25_display.json", EXAMPLES / "re25_rc_display.json",
                         "--svg", picture, "-o", result, "--points", "5")
        names = [json.loads((EXAMPLES / f"{n}.json").read_text())["name"]
                 for n in ("re25_display", "re25_rc_display")]
        page = folder / "report.html"
        self.assertEqual(self.run_program("report", result, "-o", page).code, 0)
        for name in names:
            self.assertIn(name, picture.read_text())
            self.assertIn(name, page.read_text())


if __name__ == "__main__":
    unittest.main()
