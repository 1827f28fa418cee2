"""Passivity control, predictive wall and contact effects as a user meets them."""
import json
import math
import unittest

from program import EXAMPLES, ProgramTest, with_value

BALL = EXAMPLES / "ball_bounce"
CONTROL = EXAMPLES / "passivity_control"


def load(path):
    return json.loads(path.read_text())


class BallBounceTest(ProgramTest):

    def run_ball(self, name):
        return self.ask("simulate", BALL / f"{name}.json", "--duration", "1.5 s")

    def test_the_plain_floor_gives_energy_and_the_dead_beat_floor_none(self):
        drop = 3.49236 * 0.08
        self.assertGreater(self.run_ball("plain")["energy"]["source"], 2 * drop)
        self.assertLess(self.run_ball("half_sample")["energy"]["source"], 0)
        self.assertLess(abs(self.run_ball("dead_beat")["energy"]["source"]), 1e-9 * drop)

    def test_the_dead_beat_ball_is_the_one_of_a_floor_sampled_every_10_us(self):
        fine = self.ask("simulate", BALL / "reference.json", "--duration", "0.4 s", "--csv", "fine.csv")
        self.assertEqual(fine["steps"], 40000)
        rows = (self.folder / "fine.csv").read_text().splitlines()
        at = rows[0].split(",").index("position")
        found = self.run_ball("dead_beat")["trace"]
        flying = [k for k in range(1, 40) if found["command"][k] == 0 and found["command"][k - 1] == 0]
        self.assertGreater(len(flying), 20)
        for k in flying:
            # The fine floor grows too, by K T^2/4m a sample, 2700 in contact: 1e-3 of 1.25 m/s a bounce,
            # for up to 0.25 s until the next.
            self.assertAlmostEqual(found["position"][k], float(rows[1 + 1000 * k].split(",")[at]), delta=3e-4)

    def test_the_disk_judges_the_predicted_wall_and_the_textbook_says_that_it_does_not(self):
        model = with_value(load(BALL / "dead_beat.json"), "/mechanics/damping", 30)
        result = self.ask("passivity", self.write_model(model))
        for criterion in result["criteria"]:
            self.assertEqual(criterion["applies"], criterion["name"] == "exact_disk", criterion)
        self.assertEqual(result["stiffness"], 5000)
        self.ask("zwidth", self.write_model(model), "--damping", "0,10")


class PassivityControlTest(ProgramTest):

    def test_the_published_wall_oscillates_bare_and_settles_with_either_observer(self):
        self.assertEqual(self.ask("simulate", CONTROL / "bare.json")["classification"], "limit_cycle")
        for observer in ("simple", "reference"):
            result = self.ask("simulate", CONTROL / f"{observer}.json")
            self.assertEqual(result["classification"], "settles")
            trace = result["trace"]
            self.assertTrue(any(f != 0 for f in trace["passivity_effort"]))
            # The observer reckons what the ledger measures: what the amplifier took back.
            self.assertAlmostEqual(trace["observed_energy"][-1], -result["energy"]["source"], delta=1e-9)

    def test_without_a_limit_given_the_damping_is_what_stops_the_device_in_one_sample(self):
        model = with_value(load(CONTROL / "simple.json"), "/controller/max_damping", "2 kN.s/m")
        given = self.ask("simulate", self.write_model(model))["trace"]
        self.assertEqual(given, self.ask("simulate", CONTROL / "simple.json")["trace"])
        tight = with_value(model, "/controller/max_effort", "1 N")
        trace = self.ask("simulate", self.write_model(tight))["trace"]
        self.assertEqual(max(abs(f) for f in trace["passivity_effort"]), 1)

    def test_the_verdict_says_that_it_judges_the_wrapped_law_alone(self):
        bare, wrapped = (self.ask("passivity", CONTROL / f"{name}.json") for name in ("bare", "simple"))
        self.assertEqual(bare["verdict"], wrapped["verdict"])
        self.assertIn("without passivity control", wrapped["explanation"])
        self.assertNotIn("without passivity control", bare["explanation"])

    def test_what_cannot_be_wrapped_is_refused_by_name(self):
        model = load(CONTROL / "simple.json")
        for law, reason in (({"kind": "none"}, '"none" cannot be wrapped'),
                            ({"kind": "wave", "environment": {"kind": "matched"}}, '"wave" cannot be wrapped'),
                            ({"kind": "passivity"}, "passivity"), ({"kind": "virtual_wal"}, "virtual_wall")):
            answer = self.run_program("simulate", self.write_model(with_value(model, "/controller/controller", law)))
            self.assert_refused(answer, "/controller/controller/kind", reason)
        for key in ("max_damping", "max_effort"):
            answer = self.run_program("simulate", self.write_model(with_value(model, f"/controller/{key}", 0)))
            self.assert_refused(answer, f"/controller/{key}", "above 0")
        answer = self.run_program("simulate", self.write_model(
            with_value(model, "/controller/controller/no_pull", True) |
            {"controller": {"kind": "passivity", "controller": {"kind": "virtual_wall", "stiffness": 1,
                                                                "no_pull": True}}}))
        self.assert_refused(answer, "/controller/controller/no_pull", "bilateral")


class ContactEffectsTest(ProgramTest):

    def model(self, effects, **wall):
        wall = {"kind": "virtual_wall", "stiffness": "1 kN/m", "unilateral": True} | wall
        return {"schema": "gyrator/model/1", "name": "tap", "motion": "linear", "mechanics": {"mass": "0.5 kg"},
                "amplifier": {"kind": "ideal"}, "sampling": {"period": "1 ms"},
                "controller": wall | {"contact_effects": effects},
                "simulation": {"duration": "20 ms", "initial_velocity": "0.2 m/s", "initial_position": "-0.5 mm"}}

    def test_each_effect_shows_in_the_run_and_in_the_rate_hardness(self):
        pulse = {"kind": "braking_pulse", "damping": "20 N.s/m", "mass": "0.5 kg"}
        sine = {"kind": "event_transient", "gain": "10 N.s/m", "decay_time": "10 ms", "frequency": "200 Hz"}
        match = {"kind": "acceleration_matching", "mass": "0.5 kg",
                 "transient": {"kind": "decaying_sine", "decay_time": "5 ms", "frequency": "200 Hz"}}
        tape = {"kind": "acceleration_matching", "mass": "0.5 kg", "damping": "1 N.s/m",
                "transient": {"kind": "recorded", "acceleration": [0, "50 m/s^2", 0], "time_step": "2 ms",
                              "velocity": "0.2 m/s"}}
        bare = self.ask("simulate", self.write_model(self.model([])))["rate_hardness"]
        self.assertAlmostEqual(bare, 1000, delta=20)  # slowed by K T^2/m = 0.2 % and less a sample
        for effects in ([pulse], [sine], [match], [tape], [pulse, sine, match, tape]):
            result = self.ask("simulate", self.write_model(self.model(effects)))
            self.assertGreater(result["rate_hardness"], 1.5 * bare, effects)
            self.assertTrue(all(math.isfinite(c) for c in result["trace"]["command"]))
        answer = self.run_program("simulate", self.write_model(self.model([pulse])))
        self.assertIn("rate-hardness", answer.out)
        wrapped = self.model([pulse])
        wrapped["controller"] = {"kind": "passivity", "controller": wrapped["controller"]}
        self.assertGreater(self.ask("simulate", self.write_model(wrapped))["rate_hardness"], 1.5 * bare)

    def test_a_rotary_device_takes_them_with_its_own_names(self):
        model = self.model([{"kind": "braking_pulse", "damping": "20 uN.m.s/rad", "inertia": "1e-5 kg.m^2"},
                            {"kind": "acceleration_matching", "inertia": "1e-5 kg.m^2", "transient":
                             {"kind": "recorded", "acceleration": [0, 10], "time_step": "1 ms", "velocity": 1}}])
        model |= {"motion": "rotary", "mechanics": {"inertia": "1e-5 kg.m^2"}}
        model["controller"]["stiffness"] = "0.1 N.m/rad"
        model["simulation"] = {"initial_velocity": 1, "initial_position": -0.01}
        self.ask("simulate", self.write_model(model))

    def test_what_has_no_contact_is_refused_by_name(self):
        pulse = {"kind": "braking_pulse", "damping": "20 N.s/m"}
        wall = {"kind": "virtual_wall", "stiffness": 1}
        owners = "belongs to 'virtual_wall', 'predictive_wall'"
        spring = {"stiffness": "1 kN/m"}
        scene = {"object": {"mass": 1, "stiffness": 1}, "contact": spring}
        for controller, *reasons in (
                (wall, '"virtual_wall"', "surface"), ({"kind": "none"}, "'none'", owners),
                ({"kind": "wave", "environment": {"kind": "matched"}}, "'wave'", owners),
                ({"kind": "virtual_coupling", "coupling": spring, "tool": {"mass": 1}}, "'virtual_coupling'", owners),
                (scene | {"kind": "direct"}, "'direct'", owners),
                (scene | {"kind": "equivalent_impedance"}, "'equivalent_impedance'", owners),
                (scene | {"kind": "proxy", "coupling": spring, "tool": {"mass": 1}}, "'proxy'", owners),
                ({"kind": "passivity", "controller": wall | {"unilateral": True}}, owners, "put it into 'controller'")):
            model = self.model([])
            model["controller"] = controller | {"contact_effects": [pulse]}
            answer = self.run_program("simulate", self.write_model(model))
            self.assert_refused(answer, "/controller/contact_effects", *reasons)

    def test_what_the_sampling_cannot_play_is_refused_with_its_place(self):
        sine = {"kind": "event_transient", "gain": 1, "decay_time": "10 ms", "frequency": "500 Hz"}
        answer = self.run_program("simulate", self.write_model(self.model([sine])))
        self.assert_refused(answer, "/controller/contact_effects/0/frequency", "500 Hz", "half the sampling rate")
        match = {"kind": "acceleration_matching", "mass": 1,
                 "transient": {"kind": "decaying_sine", "decay_time": "10 ms", "frequency": "1 kHz"}}
        answer = self.run_program("simulate", self.write_model(self.model([match])))
        self.assert_refused(answer, "/controller/contact_effects/0/transient/frequency", "1000 Hz")
        match["transient"] = {"kind": "recorded", "acceleration": [1], "time_step": 1, "velocity": 1}
        answer = self.run_program("simulate", self.write_model(self.model([match])))
        self.assert_refused(answer, "/controller/contact_effects/0/transient/acceleration", "list")
        answer = self.run_program("simulate", self.write_model(self.model([{"kind": "thud"}])))
        self.assert_refused(answer, "/controller/contact_effects/0/kind", "thud")

    def test_a_held_impedance_takes_no_wrappers(self):
        model = self.model([{"kind": "braking_pulse", "damping": 1}])
        model["damping"] = [{"kind": "held_impedance"}]
        answer = self.run_program("simulate", self.write_model(model))
        self.assert_refused(answer, "held_impedance", "leave them out")


class SchematicTest(ProgramTest):

    def test_every_wrapper_is_drawn(self):
        for model, texts in ((CONTROL / "reference.json", ("passivity control", "reference energy")),
                             (BALL / "dead_beat.json", ("predictive wall", "half a sample ahead"))):
            answer = self.run_program("schematic", model, "-o", "drawing.svg")
            self.assertEqual(answer.code, 0, answer)
            drawing = (self.folder / "drawing.svg").read_text()
            for text in texts:
                self.assertIn(text, drawing)


if __name__ == "__main__":
    unittest.main()
