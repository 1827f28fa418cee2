"""Hands and their gestures, noise, jitter and the converter, as a user meets them."""
import csv
import json
import math
import unittest

from program import EXAMPLES, ProgramTest, load_example, with_value, without

PUSH = EXAMPLES / "recorded_push.json"


def base(**simulation):
    """A plain model: an RE25 without controller, at rest."""
    model = load_example("re25_display")
    model["controller"] = {"kind": "none"}
    model["simulation"] = {"duration": "0.1 s", **simulation}
    return model


def with_operator(model, **operator):
    return {**model, "operator": operator}


class HandTest(ProgramTest):

    def trace(self, model):
        name = self.write_model(model)
        answer = self.run_program("simulate", name, "--csv", "trace.csv", "--quiet")
        self.assertEqual((answer.code, answer.err), (0, ""), answer)
        with open(self.folder / "trace.csv") as file:
            rows = list(csv.DictReader(file))
        return {key: [float(row[key]) for row in rows] for key in rows[0]}

    def refuse(self, model, *fragments, command="simulate"):
        self.assert_refused(self.run_program(command, self.write_model(model)), *fragments)


class OperatorTest(HandTest):

    def test_an_arm_is_the_hand_of_its_values_times_the_radius_squared(self):
        moving = base(initial_velocity=1)
        arm = self.trace(with_operator(moving, kind="arm", mass="100 g", damping="2 N.s/m", stiffness="400 N/m",
                                       radius="50 mm"))
        hand = self.trace(with_operator(moving, kind="mass_spring_damper", inertia=0.1 * 0.05 ** 2,
                                        damping=2 * 0.05 ** 2, stiffness=400 * 0.05 ** 2))
        largest = max(map(abs, hand["position"]))
        for a, b in zip(arm["position"], hand["position"]):
            self.assertAlmostEqual(a, b, delta=1e-12 * largest)

    def test_a_network_of_the_same_parts_is_the_same_hand_in_every_command(self):
        (self.folder / "hand.cir").write_text("* my hand\n.subckt hand port ground\nC1 port ground 2.5e-4\n"
                                              "R1 port ground 200\nL1 port ground 1\n.ends\n")
        model = load_example("re25_display")
        hand = {"kind": "mass_spring_damper", "inertia": 2.5e-4, "damping": 5e-3, "stiffness": 1}
        for command, key in (("simulate", "energy"), ("zwidth", "max_stiffness")):
            more = ["--criterion", "coupled", "--damping", "0,1e-4"] if command == "zwidth" else []
            answers = []
            for operator in (hand, {"kind": "network", "file": "hand.cir"}):
                answers.append(self.ask(command, self.write_model({**model, "operator": operator}), *more)[key])
            with self.subTest(command):
                a, b = (list(x.values()) if isinstance(x, dict) else x for x in answers)
                scale = max(map(abs, a))
                for x, y in zip(a, b):
                    self.assertAlmostEqual(x, y, delta=1e-6 * scale)
        for command, ending in (("schematic", "svg"), ("spice", "cir"), ("passivity", "json"), ("impedance", "json")):
            answer = self.run_program(command, "model.json", "-o", f"{command}.{ending}")
            self.assertIn(answer.code, (0, 1), answer)

    def test_a_network_that_is_not_passive_is_refused_at_its_line(self):
        model = with_operator(base(), kind="network", file="hand.cir")
        for line, code in (("V1 port ground 1", 3), ("E1 port ground port ground 0.5", 3), ("R2 port ground -1", 3)):
            (self.folder / "hand.cir").write_text(f".subckt hand port ground\nR1 port ground 200\n{line}\n.ends\n")
            with self.subTest(line):
                self.refuse(model, f"hand.cir:{code}", "model.json")
        (self.folder / "hand.cir").write_text(".subckt hand a b c\nR1 a b 1\nR2 b c 1\nR3 a c 1\n.ends\n")
        self.refuse(model, "hand.cir:1", "3 pins")
        self.refuse(with_operator(base(), kind="network", file="none.cir"), "none.cir")

    def test_bad_operators_are_refused_with_their_path(self):
        arm = {"kind": "arm", "mass": 1, "radius": 0.1}
        self.refuse({**base(), "operator": without(arm, "/radius")}, "/operator", "'radius' is missing")
        self.refuse({**base(), "operator": {**arm, "radius": 0}}, "/operator/radius", "above 0 m")
        self.refuse({**base(), "operator": {**arm, "stiffness": "1 N.m/rad"}}, "/operator/stiffness",
                    "linear stiffness")
        self.refuse({**base(), "operator": {**arm, "mass": -1}}, "/operator/mass", "at least 0 kg")


class GestureTest(HandTest):

    def test_a_hit_pushes_a_free_device_by_its_impulse(self):
        model = base(gesture={"kind": "hit", "effort": "2 mN.m", "width": "4.3 ms", "times": ["10 ms"]})
        model["mechanics"] = {"inertia": 1e-5}
        model["amplifier"] = {"kind": "ideal"}
        model["operator"] = {"kind": "free"}
        del model["motor"]
        trace = self.trace(model)
        impulse = 2e-3 * 4.3e-3 * 2 / math.pi
        self.assertAlmostEqual(sum(trace["external_effort"][:-1]) * 1e-3, impulse, delta=1e-12 * impulse)
        self.assertAlmostEqual(trace["velocity"][-1], impulse / 1e-5, delta=1e-9 * impulse / 1e-5)

    def test_every_gesture_runs_and_is_drawn(self):
        for gesture in ({"kind": "hit", "effort": 1e-3, "width": "2 ms", "repeat": "20 ms", "shape": "raised_cosine"},
                        {"kind": "hold", "effort": 1e-3, "start": "5 ms", "rise": "10 ms"},
                        {"kind": "stroke", "effort": 1e-3, "frequency": "5 Hz"},
                        {"kind": "random", "effort": 1e-3, "bandwidth": "20 Hz"}):
            name = self.write_model(base(gesture=gesture))
            result = self.ask("simulate", name, "--svg", "run.svg")
            with self.subTest(gesture["kind"]):
                self.assertIn("gesture", (self.folder / "run.svg").read_text())
                moved = abs(result["energy"]["operator"])
                self.assertGreater(moved, 0)
                self.assertLess(abs(result["energy"]["residual"]), 1e-9 * moved)

    def test_a_motion_moves_the_device_through_the_hand(self):
        model = with_operator(base(gesture={"kind": "stroke", "motion": "10 deg", "frequency": "5 Hz"}),
                              kind="mass_spring_damper", stiffness=2, damping=5e-3)
        largest = max(self.trace(model)["position"])
        self.assertAlmostEqual(largest, math.radians(10), delta=0.2 * math.radians(10))

    def test_gestures_that_cannot_be_are_refused_with_their_path(self):
        hit = {"kind": "hit", "effort": 1, "width": "5 ms"}
        motion = {"kind": "stroke", "motion": 0.1, "frequency": 5}
        self.refuse(with_operator(base(gesture=hit), kind="clamped"), "/simulation/gesture", "clamped")
        self.refuse(with_operator(base(gesture=motion), kind="free"), "/simulation/gesture", "stiffness or a damping")
        self.refuse(with_operator(base(gesture=motion), kind="mass_spring_damper", inertia=1e-5),
                    "/simulation/gesture", "stiffness or a damping")
        self.refuse(base(gesture={**hit, "repeat": "4 ms"}), "/simulation/gesture/repeat", "0.004 s", "0.005 s")
        self.refuse(base(gesture={**hit, "width": 0}), "/simulation/gesture/width", "above 0 s")
        self.refuse(base(gesture={**hit, "times": []}), "/simulation/gesture/times")
        self.refuse(base(gesture={**motion, "effort": 1}), "/simulation/gesture", "effort", "motion")
        self.refuse(base(gesture={"kind": "random", "effort": -1, "bandwidth": 20}), "/simulation/gesture/effort",
                    "-1 N.m", "at least 0")
        self.refuse(base(gesture={"kind": "hits"}), "/simulation/gesture/kind", "did you mean 'hit'?")
        self.refuse(base(gesture=hit, seed=-1), "/simulation/seed", "at least 0")


class RecordingTest(HandTest):

    def model(self, text, **more):
        (self.folder / "push.csv").write_text(text)
        return base(gesture={"kind": "recorded", "file": "push.csv", "column": "torque", "quantity": "force", **more})

    def test_a_recorded_sine_is_the_sine(self):
        rows = "".join(f"{k * 1e-4!r},{1e-3 * math.sin(2 * math.pi * 5 * k * 1e-4)!r}\n" for k in range(1001))
        read = self.trace(self.model("time_s,torque\n" + rows))
        sine = self.trace(base(gesture={"kind": "stroke", "effort": 1e-3, "frequency": 5}))
        bound = 1e-3 * (2 * math.pi * 5 * 1e-4) ** 2 / 8  # of straight pieces
        for a, b in zip(read["external_effort"], sine["external_effort"]):
            self.assertAlmostEqual(a, b, delta=bound)

    def test_a_recording_with_a_gap_or_times_that_do_not_increase_is_refused_at_its_line(self):
        for rows, line, column, said in (("0,1\n1,\n", 3, "torque", "a gap"), ("0,1\n1\n", 3, "torque", "a gap"),
                                         ("0,1\n1,NaN\n", 3, "torque", "a gap"),
                                         ("0,1\n,2\n", 3, "time_s", "a gap"),
                                         ("0,1\n1,inf\n", 3, "torque", "'inf': not finite"),
                                         ("0,one\n1,2\n", 2, "torque", "'one'"),
                                         ("0,1\n1,2\n1,3\n", 4, "time_s", "1 s after 1 s"),
                                         ("0,1\n1,2\n0.5,3\n", 4, "time_s", "0.5 s after 1 s"),
                                         ("0,1\n0.05,2\n", 3, "time_s", "0.05 s")):
            with self.subTest(rows):
                self.refuse(self.model("time_s,torque\n" + rows), f'push.csv:{line}: column "{column}": ', said)

    def test_a_missing_file_or_column_is_refused_with_those_there_are(self):
        self.refuse(self.model("time_s,torqe\n0,1\n1,2\n"), "push.csv:1", "no column 'torque'",
                    "'torqe' is nearly its name")
        self.refuse(self.model("t,torque\n0,1\n1,2\n"), "push.csv:1", "no column 'time_s'",
                    "there are: t, torque")
        self.refuse(self.model(""), "push.csv", "is empty")
        self.refuse(self.model("time_s,torque\n0,1\n1,2,5\n"), "push.csv:3", "3 fields", "the header has 2")
        self.refuse(self.model("time_s,torque,torque\n0,1,2\n"), 'push.csv:1: column "torque"', "two of this name")
        self.refuse(self.model("time_s,torque\n"), "push.csv", "no row")
        self.refuse(self.model("time_s,torque\n0,1\n", file="none.csv"), "none.csv", "cannot be read")

    def test_a_longer_duration_on_the_command_line_is_refused_too(self):
        name = self.write_model(self.model("time_s,torque\n0,1e-3\n0.1,2e-3\n"))
        self.assertEqual(self.run_program("simulate", name).code, 0)
        self.assert_refused(self.run_program("simulate", name, "--duration", "0.2 s"), 'push.csv:3: column "time_s"',
                            "0.1 s", "0.2 s")

    def test_the_example_runs_from_anywhere(self):
        result = self.ask("simulate", PUSH)
        self.assertGreater(result["energy"]["operator"], 0)
        self.assertIn("external_effort", result["trace"])


class LoopTest(HandTest):

    def test_the_converter_rounds_and_saturates_what_is_applied(self):
        model = with_value(load_example("re25_display"), "/simulation/duration", "50 ms")
        model["dac"] = {"quantum": "1 mN.m", "limit": "5.5 mN.m"}
        model["controller"] = {"kind": "virtual_wall", "stiffness": 1}
        model["sampling"] = {"period": "1 ms"}
        model["simulation"]["initial_position"] = 0.02
        trace = self.trace(model)
        for asked, applied in zip(trace["command"], trace["held_command_after"]):
            expected = max(-5.5e-3, min(5.5e-3, 1e-3 * math.floor(asked / 1e-3 + 0.5)))
            self.assertAlmostEqual(applied, expected, delta=1e-15)
        self.assertIn(-5.5e-3, trace["held_command_after"])

    def test_the_seed_decides_about_noise_and_jitter_and_is_told(self):
        model = base()
        model["sensor"] = {"noise": "0.01 deg"}
        model["sampling"] = {"period": "1 ms", "jitter": "0.2 ms"}
        first, again, other = (self.trace(with_value({**model, "simulation": {"duration": "50 ms", "seed": seed}},
                                                     "/name", "x")) for seed in (1, 1, 2))
        self.assertEqual(first, again)
        self.assertNotEqual(first["time_s"], other["time_s"])
        self.assertNotEqual(first["measured_position"], other["measured_position"])
        self.assertEqual(self.ask("simulate", "model.json")["seed"], 2)

    def test_values_that_cannot_be_are_refused_with_their_path(self):
        model = base()
        model["sampling"] = {"period": "1 ms", "jitter": "0.5 ms"}
        for command in ("simulate", "passivity"):
            self.refuse(model, "/sampling/jitter", "0.0005 s", "below half the period", command=command)
        self.refuse({**base(), "sensor": {"noise": -1}}, "/sensor/noise", "at least 0 rad")
        self.refuse({**base(), "dac": {"limit": 0}}, "/dac/limit", "above 0 N.m")
        self.refuse({**base(), "dac": {"quantum": "1 N"}}, "/dac/quantum", "torque")
        self.refuse(with_value(load_example("wave_display"), "/sensor", {"noise": 1e-5}), "/sensor/noise", "wave")
        model["sampling"]["jitter"] = "0.1 ms"
        self.refuse(model, "/sampling/jitter", "even samples", command="spice")

    def test_a_command_that_is_no_number_names_step_and_time_and_keeps_the_trace(self):
        model = load_example("re25_display")
        model["controller"] = {"kind": "virtual_wall", "stiffness": 1e300}
        model["simulation"]["initial_position"] = 1e10
        answer = self.run_program("simulate", self.write_model(model), "--csv", "trace.csv")
        self.assert_refused(answer, "t = 0 s: step 0", "command of -inf", "the run up to t = 0 s is in trace.csv", code=3)
        self.assertIn("-inf", (self.folder / "trace.csv").read_text())

    def test_a_ledger_that_does_not_close_keeps_the_trace(self):
        model = with_value(load_example(), "/motor/inductance", 1e-30)
        answer = self.run_program("simulate", self.write_model(model), "--csv", "trace.csv", "-o", "run.json")
        if answer.code == 0:
            self.skipTest("the ledger closes")
        self.assertEqual(answer.code, 3, answer)
        self.assertIn("is in trace.csv, run.json", answer.err)
        self.assertEqual(json.loads((self.folder / "run.json").read_text())["failure"]["exit_code"], 3)


if __name__ == "__main__":
    unittest.main()
