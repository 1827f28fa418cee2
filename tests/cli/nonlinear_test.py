"""Models that are not linear: what is picked, what is refused, and how far linear answers hold."""

import copy
import unittest

from program import ProgramTest, load_example

BRAKE = {"kind": "friction_brake", "damping": "1 mN.m.s/rad", "effort": "0.2 mN.m"}
CLAMP = {"kind": "clamp", "voltage": "20 mV"}


def bent():
    model = load_example()
    model["amplifier"] = {"kind": "current", "bandwidth": "400 Hz", "current_limit": "2 A",
                          "voltage_limit": "24 V"}
    model["damping"] += [BRAKE, CLAMP]
    model["motor"]["thermal"] = {"resistance": "5 K/W", "capacity": "20 J/K"}
    return model


class NonlinearTest(ProgramTest):
    def test_simulate_picks_cvode_and_says_why(self):
        model = self.write_model(bent())
        result = self.ask("simulate", model)
        self.assertEqual(result["engine"], "cvode")
        self.assertEqual(result["nonlinear_element"], "damping.1.brake")
        self.assertIn("winding_temperature_rise", result["trace"])
        energy = result["energy"]
        moved = abs(energy["operator"]) + abs(energy["source"]) + energy["dissipated"]
        self.assertLess(abs(energy["residual"]), 1e-6 * moved)
        text = self.run_program("simulate", model).out
        self.assertIn("engine cvode (damping.1.brake is not linear)", text)
        linear = self.ask("simulate", self.write_model(load_example()))
        self.assertEqual((linear["engine"], linear["nonlinear_element"]), ("exact", None))

    def test_the_exact_engine_is_refused_by_name(self):
        answer = self.run_program("simulate", self.write_model(bent()), "--engine", "exact")
        self.assertEqual(answer.code, 2)
        for word in ("--engine", "motor.resistance", "cvode"):
            self.assertIn(word, answer.err)

    def test_linear_answers_say_how_far_they_hold(self):
        model = self.write_model(bent())
        for command in (("impedance",), ("passivity",), ("zwidth", "--damping", "0")):
            result = self.ask(command[0], model, *command[1:])
            ranges = {r["element"]: r for r in result["operating_point"]["linear_range"]}
            self.assertEqual(ranges["damping.1.brake"]["quantity"], "velocity")
            self.assertEqual(ranges["damping.1.brake"]["unit"], "rad/s")
            self.assertAlmostEqual(ranges["damping.1.brake"]["to"], 0.2, places=12)
            self.assertAlmostEqual(ranges["damping.2.clamp"]["from"], -0.02, places=12)
            self.assertAlmostEqual(ranges["amplifier.voltage_limit"]["to"], 24, places=9)
            self.assertEqual(ranges["amplifier.current_limit"]["quantity"], "command")
            # 1 A K_t; of it the clamp's leakage of 1e-6 S takes R_m 1e-6
            self.assertAlmostEqual(ranges["amplifier.current_limit"]["to"], 0.1, delta=2e-6 * 0.1)
            self.assertAlmostEqual(ranges["motor.resistance"]["to"], 0.01 / 0.00393, places=9)
        text = self.run_program("impedance", model).out
        self.assertIn("|velocity| < 200 mrad/s", text)
        self.assertIsNone(self.ask("impedance", self.write_model(load_example()))["operating_point"])

    def test_slopes_at_rest_are_those_of_the_model_without_limits(self):
        plain = bent()
        plain["amplifier"] = {"kind": "current", "bandwidth": "400 Hz"}
        plain["damping"] = plain["damping"][:1] + [
            {"kind": "eddy_current_brake", "damping": BRAKE["damping"]},
            {"kind": "resistor", "resistance": 1e6}]  # the clamp's leakage
        del plain["motor"]["thermal"]
        ours = self.ask("impedance", self.write_model(bent()))
        theirs = self.ask("impedance", self.write_model(plain))
        for a, b in zip(ours["impedance_real"], theirs["impedance_real"]):
            self.assertAlmostEqual(a / b, 1, places=10)

    def test_values_without_meaning_are_refused(self):
        for path, value in ((("amplifier", "current_limit"), 0), (("amplifier", "voltage_limit"), -1),
                            (("motor", "thermal", "capacity"), 0), (("damping", 1, "effort"), 0),
                            (("damping", 2, "voltage"), "1 A")):
            model = copy.deepcopy(bent())
            place = model
            for key in path[:-1]:
                place = place[key]
            place[path[-1]] = value
            answer = self.run_program("simulate", self.write_model(model))
            self.assertEqual(answer.code, 2, path)
            self.assertIn("/".join(str(p) for p in path), answer.err)


if __name__ == "__main__":
    unittest.main()
