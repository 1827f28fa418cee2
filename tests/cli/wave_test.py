"""The wave-variable drive as a user meets it: verdict, boundary, run, and what is refused."""
import json
import math
import unittest

from program import EXAMPLES, ProgramTest, load_example, with_value, without

WAVE = EXAMPLES / "wave_display.json"


class WaveTest(ProgramTest):

    def test_a_wall_behind_the_line_is_passive_and_the_same_wall_from_the_position_is_not(self):
        result = self.ask("passivity", WAVE)
        self.assertEqual(result["verdict"], "passive")
        self.assertEqual(result["sampled_signal"], "wave_integral")
        self.assertIsNone(next(c for c in result["criteria"] if c["name"] == "exact_disk")["max_stiffness"])
        for criterion in result["criteria"]:
            self.assertEqual(criterion["applies"], criterion["name"] == "exact_disk")
        plain = with_value(load_example("wave_display"), "/controller",
                           {"kind": "virtual_wall", "stiffness": 1})
        result = self.ask("passivity", self.write_model(plain))
        self.assertEqual((result["verdict"], result["sampled_signal"]), ("not_passive", "position"))

    def test_every_stiffness_is_passive_for_every_damping_that_takes_energy(self):
        result = self.ask("zwidth", WAVE)
        self.assertLess(result["damping"][0], 0)
        for damping, stiffness, feasible in zip(result["damping"], result["max_stiffness"], result["feasible"]):
            if damping >= 0:
                self.assertTrue(feasible and stiffness is None, (damping, stiffness))
        self.assertEqual(result["point"], {"damping": 0, "stiffness": 1})

    def test_a_run_reads_the_waves_integral(self):
        result = self.ask("simulate", WAVE)
        self.assertEqual(result["classification"], "settles")
        read = result["trace"]["measured_wave_integral"]
        self.assertEqual(read[0], 0)
        self.assertTrue(any(abs(y) > 0 for y in read))
        energy = result["energy"]
        self.assertLess(abs(energy["residual"]), 1e-9 * energy["stored_initially"])

    def test_a_linear_device_takes_a_wave_drive_too(self):
        model = load_example("wave_display")
        del model["motor"]["torque_constant"]
        model["motor"].update({"force_constant": "5 N/A"})
        model["mechanics"] = {"mass": "0.05 kg", "damping": "0.1 N.s/m"}
        model["motion"] = "linear"
        model["damping"][0]["impedance"] = "20 N.s/m"
        model["controller"]["environment"]["stiffness"] = "5 N/mm"
        self.assertEqual(self.ask("passivity", self.write_model(model))["verdict"], "passive")

    def test_the_environment_may_be_matched_or_unilateral(self):
        matched = with_value(load_example("wave_display"), "/controller/environment", {"kind": "matched"})
        self.assertEqual(self.ask("passivity", self.write_model(matched))["verdict"], "passive")
        self.assertEqual(set(self.ask("simulate", self.write_model(matched))["trace"]["command"]), {0})
        floor = with_value(load_example("wave_display"), "/controller/environment/unilateral", True)
        trace = self.ask("simulate", self.write_model(floor))["trace"]
        self.assertTrue(any(c < 0 for c in trace["command"]))
        self.assertTrue(all(math.isfinite(c) for c in trace["command"]))


class RefusalTest(ProgramTest):

    def assert_refused_at(self, model, path, *fragments):
        name = self.write_model(model)
        answer = self.run_program("passivity", name)
        self.assert_refused(answer, f"{name}: {path}: ", *fragments)

    def test_a_wave_controller_without_a_wave_drive_is_refused_with_the_remedy(self):
        model = load_example("wave_display")
        del model["damping"][0]
        self.assert_refused_at(model, "/controller/kind", '"damping"', '"voltage"')

    def test_a_wave_drive_behind_a_current_amplifier_is_refused_with_the_reason(self):
        model = with_value(load_example("wave_display"), "/amplifier", {"kind": "current"})
        del model["damping"][1]
        self.assert_refused_at(model, "/damping/0", "voltage behind a resistance")

    def test_an_impedance_below_the_amplifiers_own_resistance_is_refused_with_the_largest(self):
        model = with_value(load_example("wave_display"), "/amplifier/output_resistance", "1 ohm")
        self.assert_refused_at(model, "/damping/0/impedance", "at most 0.00055225", "1 ohm")

    def test_a_second_wave_drive_is_refused(self):
        model = load_example("wave_display")
        model["damping"].append(model["damping"][0])
        self.assert_refused_at(model, "/damping/2", "second wave")

    def test_a_position_sensors_properties_are_refused(self):
        for key, value in {"quantum": 1e-3, "offset": 0.1, "location": "motor"}.items():
            model = with_value(load_example("wave_display"), "/sensor", {key: value})
            self.assert_refused_at(model, f"/sensor/{key}", "no position")

    def test_a_damper_that_no_wave_can_answer_is_refused_with_the_bound(self):
        model = with_value(load_example("wave_display"), "/controller/environment/damping", -1e-3)
        self.assert_refused_at(model, "/controller/environment/damping", "above -0.001")

    def test_a_wave_controller_without_an_environment_is_refused(self):
        model = without(load_example("wave_display"), "/controller/environment")
        self.assert_refused_at(model, "/controller", "environment", "matched")


if __name__ == "__main__":
    unittest.main()
