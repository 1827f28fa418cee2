"""Two-ports as a user meets them: renderings of table 1, coupled devices, files, and what is refused."""
import csv
import json
import unittest

from program import EXAMPLES, ProgramTest, load_example, with_value, without

TABLE_1 = EXAMPLES / "deformable/table1.json"
P3 = EXAMPLES / "p3_plant.json"
ALL = ("direct", "proxy", "equivalent_impedance")
ENTRIES = [f"h{i}{j}_{part}" for i in "12" for j in "12" for part in ("real", "imag")]
CURVES = ["frequency_hz", *ENTRIES, "margin", "transmitted_real", "transmitted_imag"]


class RenderingTest(ProgramTest):

    def test_table_1_has_the_papers_verdicts(self):
        result = self.ask("twoport", TABLE_1, "--rendering", ",".join(ALL))
        self.assertEqual([part["rendering"] for part in result["renderings"]], list(ALL))
        self.assertEqual([part["absolutely_stable"] for part in result["renderings"]], [False, False, True])
        for part in result["renderings"]:
            holds = [condition["holds"] for condition in part["conditions"]]
            self.assertEqual(holds, [True, True, part["rendering"] == "equivalent_impedance"])
        for part in result["renderings"][:2]:
            (low, high), = part["conditions"][2]["violated_hz"]
            self.assertEqual(low, 0)
            self.assertAlmostEqual(high, 0.5 / 0.03, places=4)

    def test_the_exit_code_is_the_first_renderings(self):
        for rendering, code in (("direct", 1), ("proxy,equivalent_impedance", 1), ("equivalent_impedance,direct", 0)):
            answer = self.run_program("twoport", TABLE_1, "--rendering", rendering)
            self.assertEqual((answer.code, answer.err), (code, ""), answer)
            self.assertIn("ABSOLUTELY STABLE", answer.out)
            self.assertEqual("NOT ABSOLUTELY" in answer.out, code == 1)

    def test_the_answer_has_the_keys_of_the_interface_and_the_felt_impedance(self):
        result = self.ask("twoport", TABLE_1, "--points", "20")
        self.assertEqual(result["rendering"], "proxy")
        for key in CURVES:
            self.assertEqual(len(result[key]), 20, key)
        self.assertIs(result["absolutely_stable"], False)
        h = [complex(result[f"h{n}_real"][7], result[f"h{n}_imag"][7]) for n in ("11", "12", "21", "22")]
        z = complex(result["environment_real"][7], result["environment_imag"][7])
        felt = (h[0] + (h[0] * h[3] - h[1] * h[2]) * z) / (1 + h[3] * z)
        given = complex(result["transmitted_real"][7], result["transmitted_imag"][7])
        self.assertAlmostEqual(abs(felt / given - 1), 0, places=9)
        self.assertAlmostEqual(result["transparency"][7], abs(felt / z), places=9)

    def test_margins_have_units_of_an_impedance_an_admittance_and_none(self):
        units = [condition["unit"] for condition in self.ask("twoport", TABLE_1)["conditions"]]
        self.assertEqual(units, ["N.s/m", "m/(N.s)", "1"])
        self.assertRegex(self.run_program("twoport", TABLE_1).out, r"Re h22 >= 0 .* m/\(N\.s\) ")
        coupled = with_value(load_example(), "/controller", {
            "kind": "virtual_coupling", "coupling": {"stiffness": 0.06, "damping": 1.5e-4}, "tool": {"inertia": 1e-5}})
        units = [condition["unit"] for condition in self.ask("twoport", self.write_model(coupled))["conditions"]]
        self.assertEqual(units, ["N.m.s/rad", "rad/(N.m.s)", "1"])

    def test_what_would_do_nothing_is_refused(self):
        self.assert_refused(self.run_program("twoport", TABLE_1, "--rendering", "direct,proxy,direct"), "--rendering",
                            "direct: is there twice")
        damping = ("--passivity-damping", "1 N.s/m")
        self.assert_refused(self.run_program("twoport", TABLE_1, "--rendering", "proxy", *damping),
                            "--passivity-damping", "proxy rendering")
        self.assert_refused(self.run_program("twoport", TABLE_1, *damping), "--passivity-damping", "proxy rendering")
        answer = self.run_program("twoport", TABLE_1, "--rendering", "proxy,direct", *damping)
        self.assertIn(answer.code, (0, 1), answer)

    def test_csv_has_one_two_port_plain_and_several_by_name(self):
        self.run_program("twoport", TABLE_1, "--csv", "one.csv", "--points", "5", "--quiet")
        self.run_program("twoport", TABLE_1, "--rendering", "proxy,direct", "--csv", "two.csv", "--points", "5",
                         "--quiet")
        with open(self.folder / "one.csv", newline="") as file:
            one = list(csv.DictReader(file))
        with open(self.folder / "two.csv", newline="") as file:
            two = list(csv.DictReader(file))
        self.assertEqual(list(one[0]), [*CURVES, "transparency"])
        self.assertEqual((len(one), len(two)), (5, 5))
        for row, other in zip(one, two):
            self.assertEqual(row["h12_imag"], other["proxy_h12_imag"])
            self.assertIn("direct_margin", other)

    def test_picture_and_report(self):
        answer = self.run_program("twoport", TABLE_1, "--rendering", ",".join(ALL), "--svg", "t.svg", "-o", "t.json",
                                  "--quiet")
        self.assertEqual((answer.out, answer.err), ("", ""))
        self.assertIn("Condition 3", (self.folder / "t.svg").read_text())
        answer = self.run_program("report", "t.json", "-o", "t.html")
        self.assertEqual((answer.code, answer.err), (0, ""), answer)
        page = (self.folder / "t.html").read_text()
        self.assertIn("Not absolutely stable", page)
        self.assertIn("1.44 N·s/m of damping are missing", page)

    def test_the_damping_that_is_missing_makes_it_absolutely_stable(self):
        model = load_example("deformable/table1")
        missing = -self.ask("twoport", TABLE_1)["least_felt_damping"]["value"]
        for factor, code in ((0.99, 1), (1.01, 0)):
            varied = with_value(model, "/mechanics/damping", 0.01 + factor * missing)
            self.assertEqual(self.run_program("twoport", self.write_model(varied)).code, code)

    def test_the_stiffest_coupling_is_stable_up_to_its_limit(self):
        model = load_example("deformable/table1")
        model["mechanics"]["damping"] = "0.1 N.s/m"
        model["controller"] = {"kind": "direct", "object": model["controller"]["object"],
                               "contact": {"stiffness": "1 N/m", "damping": "0.06 N.s/m"}}
        for sensing in ("velocity", "position"):
            limits = self.ask("twoport", self.write_model(model))["coupling_limits"]
            limit, = (entry["max_stiffness"] for entry in limits if entry["sensing"] == sensing)
            for factor, code in ((0.99, 0), (1.01, 1)):
                varied = with_value(model, "/controller/contact/stiffness", factor * limit)
                answer = self.run_program("twoport", self.write_model(varied), "--sensing", sensing)
                self.assertEqual(answer.code, code, answer)


class RemoteTest(ProgramTest):

    def couple(self, *more):
        return self.run_program("twoport", P3, "--remote", P3, "--coupling-stiffness", "100 N/m", *more)

    def test_two_devices_are_stable_up_to_the_delay_that_their_damping_pays_for(self):
        # b = 0.8 N.s/m, B = 0, velocity sensed: K t <= b.
        self.assertEqual(self.couple("--delay", "7.9ms", "--sensing", "velocity").code, 0)
        self.assertEqual(self.couple("--delay", "8.1ms", "--sensing", "velocity").code, 1)

    def test_a_sampled_coupling_of_two_devices_has_a_largest_stiffness(self):
        # By default the position is sensed: each half of the coupling is a wall of 2 K, 2 K T/2 <= b.
        for stiffness, code in (("799 N/m", 0), ("801 N/m", 1)):
            answer = self.run_program("twoport", P3, "--remote", P3, "--coupling-stiffness", stiffness)
            self.assertEqual(answer.code, code, answer)

    def test_the_answer_names_both_devices_and_what_joins_them(self):
        answer = self.couple("--delay", "7ms", "--delay-back", "3ms", "--coupling-at", "slave", "--json")
        remote = answer.json["remote"]
        self.assertEqual((remote["stiffness"], remote["delay_there_s"], remote["delay_back_s"], remote["coupling_at"]),
                         (100, 0.007, 0.003, "slave"))
        self.assertEqual(remote["name"], json.loads(P3.read_text())["name"])
        for key in CURVES:
            self.assertEqual(len(answer.json[key]), 200, key)

    def test_devices_of_two_kinds_or_two_rates_are_refused(self):
        answer = self.run_program("twoport", P3, "--remote", EXAMPLES / "rc_display.json", "--coupling-stiffness", "1")
        self.assert_refused(answer, "/motion", "p3_plant.json")
        slow = self.write_model(with_value(load_example("p3_plant"), "/sampling/period", "2 ms"))
        answer = self.run_program("twoport", P3, "--remote", slow, "--coupling-stiffness", "1 N/m")
        self.assert_refused(answer, "/sampling/period", "0.002 s", "0.001 s")


class RefusalTest(ProgramTest):

    def test_no_environment_behind_a_coupling(self):
        for name in ("rc_display", "p3_plant"):
            self.assert_refused(self.run_program("twoport", EXAMPLES / f"{name}.json"), "/controller/kind",
                                "virtual_coupling", "--remote")
        bare = without(load_example("p3_plant"), "/controller")
        self.assert_refused(self.run_program("twoport", self.write_model(bare)), "/controller/kind")

    def test_renderings_that_do_not_exist_or_lack_values(self):
        self.assert_refused(self.run_program("twoport", TABLE_1, "--rendering", "direct,proxi"), "--rendering",
                            "did you mean 'proxy'")
        direct = EXAMPLES / "deformable/direct.json"
        self.assert_refused(self.run_program("twoport", direct, "--rendering", "proxy"), "/controller/tool", "proxy")

    def test_frequencies_beyond_nyquist_and_unknown_words(self):
        self.assert_refused(self.run_program("twoport", TABLE_1, "--to", "20"), "--to", "16.6667 Hz")
        self.assert_refused(self.run_program("twoport", TABLE_1, "--from", "0"), "--from", "above 0 Hz")
        self.assert_refused(self.run_program("twoport", TABLE_1, "--sensing", "speed"), "--sensing", "position")

    def test_options_of_the_other_kind_of_two_port(self):
        self.assert_refused(self.run_program("twoport", TABLE_1, "--delay", "1ms"), "--delay", "--remote")
        self.assert_refused(self.run_program("twoport", P3, "--remote", P3), "--coupling-stiffness", "missing")
        self.assert_refused(self.run_program("twoport", P3, "--remote", P3, "--coupling-stiffness", "1", "--rendering",
                                             "direct"), "--rendering")
        self.assert_refused(self.run_program("twoport", P3, "--remote", P3, "--coupling-stiffness", "-1 N/m"),
                            "--coupling-stiffness", "at least 0")


if __name__ == "__main__":
    unittest.main()
