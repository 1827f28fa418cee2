"""The netlist that ngspice runs unchanged, and the check against it."""
import os
import subprocess
import unittest

from program import RC_DISPLAY, ProgramTest, example_models, load_example, with_value


def read_table(path):
    lines = path.read_text().splitlines()
    return lines[0].split(), [[float(word) for word in line.split()] for line in lines[1:] if line.strip()]


class SpiceTest(ProgramTest):

    def deviations(self, model, *more):
        answer = self.run_program("spice", model, "--check", "--json", *more)
        self.assertEqual(answer.code, 0, answer)
        self.assertTrue(answer.json["agrees"])
        return {d["quantity"]: d for d in answer.json["deviations"]}

    def test_ngspice_agrees_on_every_example(self):
        for model in example_models():
            with self.subTest(model=model.name):
                found = self.deviations(model)
                self.assertLess(found["impedance"]["worst"], 1e-6)
                self.assertLess(found["actuation"]["worst"], 1e-6)
                self.assertLess(found["position"]["worst"], 1e-4)

    def test_ngspice_agrees_whatever_holds_the_port_and_wherever_the_sensor_is(self):
        model = with_value(load_example(), "/mechanics/transmission",
                           {"stiffness": 20, "damping": 1e-3, "load_inertia": 1e-5})
        model = with_value(with_value(model, "/sensor/location", "motor"), "/simulation/duration", "0.1 s")
        for held_by in ({"kind": "clamped"},
                        {"kind": "mass_spring_damper", "inertia": 1e-4, "damping": 1e-3, "stiffness": 1}):
            name = self.write_model(with_value(with_value(model, "/operator", held_by),
                                               "/simulation/external_effort", 0.02))
            with self.subTest(held_by=held_by["kind"]):
                self.deviations(name)

    def test_ngspice_agrees_behind_a_filter_of_either_order(self):
        for order in (1, 2):
            model = with_value(load_example(), "/sensor/filter", {"cutoff": "80 Hz", "order": order})
            model["simulation"] |= {"duration": "0.1 s", "initial_position": 0.01, "initial_velocity": 0.5}
            with self.subTest(order=order):
                found = self.deviations(self.write_model(model))
                self.assertLess(found["position"]["worst"], 1e-4)

    def test_ngspice_agrees_on_every_law_that_bends(self):
        current = {"kind": "current", "bandwidth": "400 Hz"}
        clamp = {"kind": "clamp", "voltage": "20 mV"}
        brake = {"kind": "friction_brake", "damping": "1 mN.m.s/rad", "effort": "0.2 mN.m"}
        warm = {"resistance": "5 K/W", "capacity": "20 mJ/K"}
        netlists = {
            "antiparallel diodes": "D1 a b X\nD2 b a X\n.model X D(Is=10m Rs=50m)",
            # 4 mA through a diode, which small signals meet as 6 ohm.
            "a bias": "V1 s b 5\nR1 s n 1k\nD1 n b X\nC1 n a 100u\n.model X D",
            "a bias current": "I1 b n 1m\nD1 n b X\nC1 n a 100u\n.model X D",
            "an op-amp at its limits": "X1 m b o opamp Aol=1k GBW=100k Vmax=30m\nR1 a m 1k\nR2 m o 3k\nR3 a o 1",
        }
        cases = {
            "clamp": {"damping": [clamp]},
            "friction brake": {"damping": [brake]},
            "current limit": {"amplifier": current | {"current_limit": "10 mA"}},
            "voltage limit": {"amplifier": current | {"voltage_limit": "20 mV"}},
            "voltage amplifier": {"amplifier": {"kind": "voltage", "bandwidth": "800 Hz", "output_resistance": 0.7,
                                                "voltage_limit": "50 mV", "current_limit": "10 mA"}},
            "warming winding": {"motor": {"temperature_rise": 20, "thermal": warm}},
            "all at once, held by a hand": {
                "amplifier": current | {"current_limit": "30 mA", "voltage_limit": "40 mV"},
                "damping": [clamp, brake], "motor": {"thermal": warm},
                "operator": {"kind": "mass_spring_damper", "inertia": 1e-4, "damping": 1e-3, "stiffness": 1}},
        }
        for i, (name, lines) in enumerate(netlists.items()):
            file = f"netlist{i}.cir"
            (self.folder / file).write_text(f"* {name}\n.subckt c a b\n{lines}\n.ends\n")
            cases[name] = {"damping": [{"kind": "netlist", "file": file}]}
        for name, change in cases.items():
            model = load_example()
            model["simulation"] |= {"duration": "50 ms", "initial_velocity": 2}
            model["motor"] |= change.get("motor", {})
            model["damping"] += change.get("damping", [])
            model |= {key: change[key] for key in ("amplifier", "operator") if key in change}
            with self.subTest(name):
                found = self.deviations(self.write_model(model))
                self.assertLess(found["impedance"]["worst"], 1e-6)
                for quantity in ("position", "velocity", "current"):
                    self.assertLess(found[quantity]["worst"], 1e-4)

    def test_a_delay_across_periods_is_in_the_held_command(self):
        model = with_value(load_example(), "/sampling/delay", "2.3 ms")
        self.deviations(self.write_model(with_value(model, "/simulation/duration", "0.1 s")))

    def test_ngspice_runs_the_file_unchanged_and_leaves_the_tables_that_are_promised(self):
        answer = self.run_program("spice", RC_DISPLAY, "-o", "My display.cir", "--duration", "20 ms")
        self.assertEqual((answer.code, answer.err), (0, ""), answer)
        done = subprocess.run(["ngspice", "-n", "-b", "My display.cir"], cwd=self.folder, timeout=20,
                              stdin=subprocess.DEVNULL, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        names, rows = read_table(self.folder / "my_display_impedance.data")
        self.assertEqual(names, ["frequency", "impedance", "impedance", "actuation", "actuation"])
        self.assertEqual(len(rows), 5 * 20 + 1)
        names, rows = read_table(self.folder / "my_display_motion.data")
        self.assertEqual(names, ["time", "position", "velocity", "command", "current"])
        self.assertAlmostEqual(rows[-1][0], 0.02, delta=1e-12)

    def test_the_netlist_goes_to_standard_output_and_into_json(self):
        answer = self.run_program("spice", RC_DISPLAY, "--duration", "5ms")
        self.assertTrue(answer.out.startswith("RC-damped rotary display\n"), answer)
        self.assertTrue(answer.out.endswith("\n.end\n"), answer)
        self.assertEqual(self.ask("spice", RC_DISPLAY, "--duration", "5ms")["netlist"], answer.out)

    def test_without_ngspice_the_check_is_refused_with_the_remedy(self):
        answer = self.run_program("spice", RC_DISPLAY, "--check", environment={**os.environ, "PATH": ""})
        self.assert_refused(answer, "ngspice: is not installed", "apt-get install ngspice")

    def test_a_wrong_option_is_refused_by_name(self):
        for words in (("--from", "0"), ("--to", "0.01"), ("--duration", "0"), ("--max-step", "-1 us"),
                      ("--points-per-decade", "0"), ("-o", str(RC_DISPLAY))):
            answer = self.run_program("spice", RC_DISPLAY, *words)
            with self.subTest(words=words):
                self.assert_refused(answer, "--output" if words[0] == "-o" else words[0])

    def test_friction_and_stops_are_left_out_and_the_deck_says_so(self):
        without = self.write_model(load_example(), "without.json")
        name = self.write_model(with_value(load_example(), "/mechanics/coulomb_friction", 1e-3))
        said = "* Left out, run and deck alike: dry friction and hard stops of the mechanics.\n\n"
        deck = self.run_program("spice", name).out
        self.assertIn(said, deck)
        self.assertEqual(len(deck.splitlines()), len(self.run_program("spice", without).out.splitlines()) + 2)


if __name__ == "__main__":
    unittest.main()
