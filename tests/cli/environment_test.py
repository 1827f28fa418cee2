"""Simulated environments as a user meets them: deformable objects at 30 Hz, tools, and what is refused."""
import json
import unittest

from program import EXAMPLES, ProgramTest, load_example, with_value

NAMES = ("direct", "proxy", "equivalent_impedance")


def load(name):
    return load_example(f"deformable/{name}")


def coupled(**more):
    model = load_example("p3_plant")
    model["controller"] = {"kind": "virtual_coupling", "tool": {"mass": "10 g"},
                           "coupling": {"stiffness": "300 N/m", "damping": "0.2 N.s/m"}, **more}
    return model


class DeformableTest(ProgramTest):

    def test_pressed_at_thirty_hertz_only_the_equivalent_impedance_comes_to_rest(self):
        outcomes = {}
        for name in NAMES:
            result = self.ask("simulate", EXAMPLES / "deformable" / f"{name}.json")
            outcomes[name] = result["classification"]
        self.assertEqual(outcomes["equivalent_impedance"], "settles")
        self.assertNotEqual(outcomes["direct"], "settles")

    def test_the_equivalent_impedance_settles_where_springs_in_series_say(self):
        trace = self.ask("simulate", EXAMPLES / "deformable/equivalent_impedance.json")["trace"]
        felt = 3000 * 300 / 3300
        self.assertAlmostEqual(trace["position"][-1], 2 / (100 + felt), delta=1e-5)

    def test_the_papers_tool_diverges_unless_its_steps_are_divided(self):
        model = load("proxy")
        model["controller"]["integration"] = "semi_implicit"
        model["operator"]["damping"] = "10 N.s/m"
        model["simulation"]["duration"] = "3 s"
        self.assertEqual(self.ask("simulate", self.write_model(model))["classification"], "diverges")
        model["controller"]["substeps"] = 53
        self.assertEqual(self.ask("simulate", self.write_model(model))["classification"], "settles")

    def test_a_slow_period_and_an_update_say_the_same(self):
        inherited = load("direct")
        own = load("direct")
        del own["sampling"]["slow_period"]
        own["controller"]["update"] = {"period": "1/30 s"}
        for model in (inherited, own):
            model["simulation"]["duration"] = "0.5 s"
        traces = [self.ask("simulate", self.write_model(m))["trace"]["position"] for m in (inherited, own)]
        self.assertEqual(*traces)

    def test_losses_come_from_the_seed(self):
        model = load("direct")
        model["simulation"]["duration"] = "1 s"
        def run(seed):
            model["controller"]["update"] = {"loss": 0.4, "seed": seed, "delay": "5 ms"}
            return self.ask("simulate", self.write_model(model))["trace"]["command"]
        self.assertEqual(run(1), run(1))
        self.assertNotEqual(run(1), run(2))


class VirtualCouplingTest(ProgramTest):

    def test_the_verdict_names_the_smallest_tool(self):
        result = self.ask("passivity", self.write_model(coupled()))
        self.assertEqual(result["verdict"], "passive")
        masses = result["minimum_mass"]
        # T/2 b_w b/(b - b_w), b_w = K T/2 + B = 0.35, b = 0.8
        self.assertAlmostEqual(masses["semi_implicit"] / (0.5e-3 * 0.35 * 0.8 / 0.45), 1, delta=1e-4)
        self.assertEqual((masses["explicit"], masses["implicit"], masses["tool"]), (None, 0, 0.01))
        self.assertEqual(masses["chosen"], masses["semi_implicit"])
        text = self.run_program("passivity", self.write_model(coupled())).out
        self.assertIn("smallest passive tool: none explicit, 311.1", text)

    def test_a_tool_that_is_too_light_is_not_passive(self):
        model = with_value(coupled(), "/controller/tool/mass", "0.3 g")
        result = self.run_program("passivity", self.write_model(model), "--json")
        self.assertEqual(result.code, 1)
        self.assertEqual(json.loads(result.out)["verdict"], "not_passive")

    def test_it_meets_a_wall_at_a_slow_rate(self):
        model = coupled(environment={"kind": "virtual_wall", "stiffness": "900 N/m", "damping": "5 N.s/m",
                                     "unilateral": True},
                        update={"period": "1/60 s", "delay": "2 ms"}, integration="implicit")
        model["simulation"] = {"duration": "3 s", "external_effort": "0.1 N"}
        result = self.ask("simulate", self.write_model(model))
        self.assertEqual(result["classification"], "settles")
        self.assertAlmostEqual(result["trace"]["position"][-1], 0.1 / 300 + 0.1 / 900, delta=1e-6)


class RefusalTest(ProgramTest):

    def assert_refused_at(self, model, path, *fragments, command="simulate"):
        name = self.write_model(model)
        self.assert_refused(self.run_program(command, name), f"{name}: {path}: ", *fragments)

    def test_rates_that_do_not_nest(self):
        self.assert_refused_at(with_value(load("direct"), "/sampling/slow_period", "0.5 ms"),
                               "/sampling/slow_period", "rates that do not nest", "0.001 s")
        model = load("direct")
        model["controller"]["update"] = {"period": "0.5 ms"}
        self.assert_refused_at(model, "/controller/update/period", "rates that do not nest")

    def test_a_loss_that_is_no_probability_and_a_negative_delay(self):
        model = load("direct")
        for loss in (1, 1.5, -0.1):
            model["controller"]["update"] = {"loss": loss}
            self.assert_refused_at(model, "/controller/update/loss", "below 1")
        model["controller"]["update"] = {"delay": "-1 ms"}
        self.assert_refused_at(model, "/controller/update/delay", "at least 0")

    def test_a_slow_period_that_nothing_takes(self):
        model = load_example("p3_plant")
        model["sampling"]["slow_period"] = "1/30 s"
        self.assert_refused_at(model, "/sampling/slow_period", "virtual_coupling", "equivalent_impedance")

    def test_no_verdict_on_two_rates(self):
        self.assert_refused_at(load("direct"), "/controller/update", "no one H(z)", "simulate",
                               command="passivity")

    def test_a_weightless_tool(self):
        self.assert_refused_at(with_value(coupled(), "/controller/tool/mass", 0), "/controller/tool/mass", "above 0")

    def test_an_unknown_scheme(self):
        model = coupled(integration="implict")
        self.assert_refused_at(model, "/controller/integration", "implicit")


if __name__ == "__main__":
    unittest.main()
