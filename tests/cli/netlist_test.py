"""A damping circuit from a SPICE file: loaded beside its model, judged, and refused where it is wrong."""

import copy
import shutil
import unittest

from program import ROOT, ProgramTest

SPICE = ROOT / "tests" / "data" / "spice"

RE25 = {
    "schema": "gyrator/model/1", "name": "RE25 with a netlist", "motion": "rotary",
    "motor": {"torque_constant": "23.5 mN.m/A", "resistance": "2.06 ohm", "inductance": "0.238 mH"},
    "mechanics": {"inertia": 1.07e-6, "damping": 1.2e-6},
    "amplifier": {"kind": "current", "bandwidth": "5 kHz"},
    "damping": [],
    "sampling": {"period": "1 ms"},
    "controller": {"kind": "virtual_wall", "stiffness": "1 mN.m/rad", "damping": 0},
    "simulation": {"initial_velocity": 1},
}

# What acts as an inductor would short the motor at DC: in series with a capacitor.
RESONANT = """* resonant
.include ltspice_gyrator.net
.subckt resonant a b
C1 a n 10u
X1 n b simulated_inductor R=1k C=10n
.ends
"""


class NetlistTest(ProgramTest):
    def model_with(self, *damping):
        model = copy.deepcopy(RE25)
        model["damping"] = list(damping)
        return self.write_model(model)

    def write_netlist(self, text, name="circuit.cir"):
        (self.folder / name).write_text(text)
        return {"kind": "netlist", "file": name}

    def assert_netlist_refused(self, text, *fragments, **members):
        damping = self.write_netlist(text) | members
        self.assert_refused(self.run_program("passivity", self.model_with(damping)), *fragments)

    def test_subcircuits_of_kicad_and_ltspice_load_and_are_judged(self):
        for name in ("kicad_parts.lib", "kicad_snubber.cir", "ltspice_coupled.net", "ltspice_gyrator.net"):
            shutil.copy(SPICE / name, self.folder)
        self.write_netlist(RESONANT, "resonant.cir")
        for file, subckt in (("kicad_snubber.cir", "SNUBBER"), ("ltspice_coupled.net", "damp"),
                             ("resonant.cir", "resonant")):
            with self.subTest(file):
                model = self.model_with({"kind": "netlist", "file": file, "subckt": subckt})
                result = self.ask("passivity", model)
                disk = next(c for c in result["criteria"] if c["name"] == "exact_disk")
                bare = self.ask("passivity", self.model_with())
                bare_disk = next(c for c in bare["criteria"] if c["name"] == "exact_disk")
                self.assertNotEqual(disk["margin"], bare_disk["margin"])
                self.assertIn(result["verdict"], ("passive", "not_passive"))
                run = self.ask("simulate", model)
                moved = sum(abs(v) for v in run["energy"].values())
                self.assertLess(abs(run["energy"]["residual"]), 1e-6 * moved)

    def test_the_same_circuit_drawn_and_named_answers_the_same(self):
        drawn = self.write_netlist("* rc\n.subckt rc 1 2\nR1 1 x 2\nC1 x 2 470u\n.ends\n")
        a = self.ask("passivity", self.model_with(drawn))
        b = self.ask("passivity", self.model_with(
            {"kind": "rc", "resistance": "2 ohm", "capacitance": "470 uF"}))
        for one, other in zip(a["criteria"], b["criteria"]):
            self.assertEqual(one["name"], other["name"])
            self.assertAlmostEqual(one["max_stiffness"], other["max_stiffness"],
                                   delta=1e-9 * other["max_stiffness"])

    def test_a_circuit_lies_where_its_model_lies(self):
        place = self.folder / "models"
        place.mkdir()
        self.write_netlist("* r\n.subckt r 1 2\nR1 1 2 5\n.ends\n", "models/circuit.cir")
        model = copy.deepcopy(RE25)
        model["damping"] = [{"kind": "netlist", "file": "circuit.cir"}]
        name = self.write_model(model, "models/model.json")
        self.ask("passivity", name)

    def test_what_cannot_be_is_refused_with_file_and_line(self):
        head = "* x\n.subckt damp a b\n"
        self.assert_netlist_refused(head + "R1 a b 5\n.ends\n", "circuit.cir", "dump", "damp", subckt="dump")
        self.assert_netlist_refused(head + "R1 a b 5\nR2 a c 5\n.ends\n", "circuit.cir:4", "c")
        self.assert_netlist_refused(head + "V1 a n 0\nE1 a n a b 2\nR1 n b 1\n.ends\n", "v1", "e1", "loop")
        self.assert_netlist_refused(head + "R1 a b -5\n.ends\n", "circuit.cir:3", "-5", "allow_negative")
        self.assert_netlist_refused(head + "R1 a b 5\nV1 a b 0\n.ends\n", "circuit.cir", "v1")
        self.assert_netlist_refused(head + "R1 a b 5\nQ1 a b 0 npn\n.ends\n", "circuit.cir:4", "Q1 a b 0 npn", "C (capacitors)")
        answer = self.run_program("passivity", self.model_with({"kind": "netlist", "file": "none.cir"}))
        self.assert_refused(answer, "none.cir")

    def test_diodes_run_by_cvode_and_linear_answers_name_their_operating_point(self):
        clamp = self.write_netlist("* clamp\n.subckt c a b\nD1 a b X\nD2 b a X\nRp a b 100\n"
                                   ".model x d is=1n n=1.5 mfg=Any\n.ends\n", "clamp.cir")
        model = self.model_with(clamp)
        run = self.ask("simulate", model)
        self.assertEqual((run["engine"], run["nonlinear_element"]), ("cvode", "damping.0.d1"))
        moved = sum(abs(v) for v in run["energy"].values())
        self.assertLess(abs(run["energy"]["residual"]), 1e-6 * moved)
        self.assertIn("engine cvode (damping.0.d1 is not linear)", self.run_program("simulate", model).out)
        ranges = self.ask("passivity", model)["operating_point"]["linear_range"]
        self.assertEqual([(r["element"], r["quantity"], r["at"]) for r in ranges],
                         [("damping.0.d1", "voltage", 0), ("damping.0.d2", "voltage", 0)])

    def test_a_bias_moves_the_operating_point(self):
        # 5 V behind 1 k and a diode, which small signals meet as V_e/I.
        biased = self.write_netlist("* bias\n.subckt c a b\nV1 s b 5\nR1 s n 1k\nD1 n b X\n"
                                    "C1 n a 10m\n.model X D\n.ends\n", "bias.cir")
        result = self.ask("passivity", self.model_with(biased))
        (diode,) = result["operating_point"]["linear_range"]
        self.assertEqual((diode["element"], diode["quantity"], diode["unit"]), ("damping.0.d1", "voltage", "V"))
        self.assertAlmostEqual(diode["at"], 0.6925, delta=5e-4)
        self.assertLess(diode["from"], diode["at"])
        self.assertLess(diode["at"], diode["to"])

    def test_a_diode_without_its_model_is_refused_with_the_nearest(self):
        self.assert_netlist_refused("* x\n.subckt c a b\nD1 a b 1N4184\n.model 1N4148 D\n.ends\n",
                                    "circuit.cir:3", "1N4184", "did you mean '1N4148'?")
        self.assert_netlist_refused("* x\n.subckt c a b\nD1 a b X\n.model X D(Cjo=4p)\n.ends\n",
                                    "circuit.cir:4", "cjo", "capacitance")

    def test_a_circuit_that_makes_the_device_oscillate_is_named(self):
        damping = self.write_netlist("* x\n.subckt damp a b\nR1 a b -3\n.ends\n")
        answer = self.run_program("impedance", self.model_with(damping | {"allow_negative": True}))
        self.assert_refused(answer, "model.json: /damping/0", "unstable", "without this damping")

    def test_a_negative_resistance_may_be_asked_for(self):
        damping = self.write_netlist("* x\n.subckt damp a b\nR1 a b 5\nR2 a b -50\n.ends\n")
        result = self.ask("impedance", self.model_with(damping | {"allow_negative": True}),
                          "--frequency", "1")
        plain = self.ask("impedance", self.model_with(
            {"kind": "resistor", "resistance": 1 / (1 / 5 - 1 / 50)}), "--frequency", "1")
        self.assertAlmostEqual(result["impedance_real"][0], plain["impedance_real"][0], delta=1e-15)


if __name__ == "__main__":
    unittest.main()
