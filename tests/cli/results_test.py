"""The answers: their shape as the interface promises it, and values that a user can check."""
import cmath
import csv
import json
import math
import os
import pathlib
import pty
import re
import subprocess
import time
import unittest

from program import (EXAMPLES, MODEL_COMMANDS, PATIENCE_S, RC_DISPLAY, ProgramTest, example_models, load_example, program,
                     with_value)

ENGINES = ("exact", "cvode", "odeint")


def engines_for(model):
    """All but odeint, which does not find where dry friction and stops switch."""
    mechanics = json.loads(pathlib.Path(model).read_text())["mechanics"]
    contacts = mechanics.get("coulomb_friction", 0) not in (0, "0") or "stops" in mechanics
    return ENGINES[:2] if contacts else ENGINES

IDEAL_PATH = EXAMPLES / "rc_display_ideal_path.json"
RE35 = EXAMPLES / "re35_rc_display.json"  # computation delay, operator and unilateral wall


def read_csv(path):
    """Column names, and rows of texts."""
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    return rows[0], rows[1:]


def column(path, name):
    names, rows = read_csv(path)
    at = names.index(name)
    return [float(row[at]) for row in rows]


def named(criteria, name):
    return next(c for c in criteria if c["name"] == name)


class JsonTest(ProgramTest):

    def test_json_prints_exactly_one_object_and_nothing_else(self):
        for command in MODEL_COMMANDS:
            answer = self.run_program(command, RC_DISPLAY, "--json")
            with self.subTest(command=command):
                value, end = json.JSONDecoder().raw_decode(answer.out)
                self.assertIsInstance(value, dict)
                self.assertEqual(answer.out[end:], "\n")
                self.assertEqual(answer.err, "")
                self.assertEqual(value["command"], command)
                self.assertEqual(value["model"], load_example())

    def test_json_holds_no_nan_and_no_infinity(self):
        def refuse(text):
            raise AssertionError(f"{text} is no JSON")
        for model in example_models():
            for command in MODEL_COMMANDS:
                few = ["--points", "9"] if command == "zwidth" else []
                answer = self.run_program(command, model, "--json", *few)
                with self.subTest(command=command, model=model.name):
                    json.loads(answer.out, parse_constant=refuse)

    def test_the_result_kept_with_o_is_what_json_prints(self):
        for command in MODEL_COMMANDS:
            printed = self.run_program(command, RC_DISPLAY, "--json", "-o", "result.json").json
            with self.subTest(command=command):
                self.assertEqual(json.loads((self.folder / "result.json").read_text()), printed)

    def test_quiet_prints_nothing_and_keeps_the_exit_code(self):
        for command in MODEL_COMMANDS:
            loud = self.run_program(command, RC_DISPLAY)
            quiet = self.run_program(command, RC_DISPLAY, "--quiet", "--csv", "out.csv")
            with self.subTest(command=command):
                self.assertGreater(len(loud.out), 100)
                self.assertEqual((quiet.code, quiet.out, quiet.err), (loud.code, "", ""))


class ImpedanceTest(ProgramTest):

    def test_the_answer_has_its_arrays_all_of_one_length(self):
        answer = self.ask("impedance", RC_DISPLAY, "--points", "17")
        for key in ("frequency_hz", "impedance_real", "impedance_imag", "actuation_real", "actuation_imag"):
            self.assertEqual(len(answer[key]), 17, key)
            self.assertTrue(all(isinstance(x, float) for x in answer[key]), key)

    def test_a_frequency_list_is_taken_as_it_is_with_units(self):
        answer = self.ask("impedance", RC_DISPLAY, "--frequency", "1,10,0.2kHz,3")
        self.assertEqual(answer["frequency_hz"], [1, 10, 200, 3])

    def test_a_sweep_is_logarithmic_from_end_to_end(self):
        frequency = self.ask("impedance", RC_DISPLAY, "--from", "0.1", "--to", "1 kHz", "--points", "9")["frequency_hz"]
        for i, f in enumerate(frequency):
            self.assertAlmostEqual(f / 10 ** (-1 + i / 2), 1, delta=1e-12)

    def test_z_and_a_are_those_of_the_circuit(self):
        # Ideal current source: the branch is in series with the winding for the back-EMF,
        # in parallel for the command.
        k, r, inductance, j, b, rd, c = 0.05, 1.5, 0.5e-3, 2e-5, 1e-4, 5, 2200e-6
        answer = self.ask("impedance", RC_DISPLAY, "--points", "40")
        for i, f in enumerate(answer["frequency_hz"]):
            s = 2j * math.pi * f
            branch, winding = rd + 1 / (s * c), r + s * inductance
            z = j * s + b + k * k / (branch + winding)
            a = branch / (branch + winding)
            found_z = complex(answer["impedance_real"][i], answer["impedance_imag"][i])
            found_a = complex(answer["actuation_real"][i], answer["actuation_imag"][i])
            self.assertLess(abs(found_z / z - 1), 1e-9, f)
            self.assertLess(abs(found_a / a - 1), 1e-9, f)
            self.assertLess(abs(cmath.phase(found_a / a)), 1e-9, f)

    def test_the_csv_holds_the_same_numbers(self):
        answer = self.ask("impedance", RC_DISPLAY, "--csv", "z.csv")
        names, rows = read_csv(self.folder / "z.csv")
        self.assertEqual(names, ["frequency_hz", "impedance_real", "impedance_imag", "actuation_real",
                                 "actuation_imag"])
        self.assertEqual(len(rows), 200)
        for name in names:
            self.assertEqual(column(self.folder / "z.csv", name), answer[name])


class CurrentLoopTest(ProgramTest):
    """A current loop inside the RC node takes the damping away; outside it delays the command."""

    def ask_with(self, sense):
        model = with_value(load_example(), "/amplifier", {"kind": "current", "bandwidth": "500 Hz", "sense": sense})
        answer = self.ask("impedance", self.write_model(model), "--frequency", "0.1,10,50,10000")
        damping = [z - 1e-4 for z in answer["impedance_real"]]
        lag = -cmath.phase(complex(answer["actuation_real"][0], answer["actuation_imag"][0])) / (2 * math.pi * 0.1)
        return damping, lag

    def test_inside_the_damping_vanishes_within_the_bandwidth_and_outside_the_command_lags(self):
        outside, lag_outside = self.ask_with("total")
        inside, lag_inside = self.ask_with("motor")
        self.assertAlmostEqual(outside[2] / (0.05 ** 2 / 6.5), 0.962, delta=0.001)  # the plateau of the branch
        self.assertLess(inside[1] / outside[1], 0.01)                              # at 10 Hz
        self.assertLess(inside[2] / outside[2], 0.04)                              # at 50 Hz
        self.assertAlmostEqual(inside[3] / outside[3], 1, delta=0.1)               # far beyond the bandwidth
        one_pole = 1 / (2 * math.pi * 500)
        self.assertAlmostEqual(lag_outside / (1.5 * 2200e-6 + one_pole), 1, delta=1e-3)  # R_m C: 3.6 ms in all
        self.assertAlmostEqual(lag_inside / one_pole, 1, delta=1e-3)                      # 0.3 ms

    def test_either_way_the_passive_wall_is_softer_than_the_textbooks(self):
        for sense in ("total", "motor"):
            model = with_value(load_example(), "/amplifier",
                               {"kind": "current", "bandwidth": "500 Hz", "sense": sense})
            criteria = self.ask("passivity", self.write_model(model), "--no-counterexample")["criteria"]
            exact, textbook = (named(criteria, name)["max_stiffness"] for name in ("exact_disk", "frequency_dependent"))
            with self.subTest(sense=sense, exact=exact, textbook=textbook):
                self.assertLess(exact, textbook)


class PassivityTest(ProgramTest):

    def wall(self, stiffness):
        return self.write_model(with_value(load_example(), "/controller/stiffness", stiffness))

    def limit(self):
        return named(self.ask("passivity", RC_DISPLAY)["criteria"], "exact_disk")["max_stiffness"]

    def test_the_answer_has_verdict_criteria_and_counterexample(self):
        for model in example_models():
            answer = self.run_program("passivity", model, "--json")
            with self.subTest(model=model.name):
                result = answer.json
                self.assertEqual(answer.code, {"passive": 0, "not_passive": 1}[result["verdict"]])
                self.assertEqual([c["name"] for c in result["criteria"]],
                                 ["spring_damper", "frequency_dependent", "exact_disk", "quantized_coulomb"])
                for criterion in result["criteria"]:
                    self.assertIsInstance(criterion["applies"], bool)
                    self.assertIsInstance(criterion["holds"], bool)
                    self.assertIsInstance(criterion["margin"], float)
                    self.assertIn("worst_frequency_hz", criterion)
                    self.assertTrue(criterion["reason"] or criterion["applies"], "says no and not why")
                self.assertEqual(named(result["criteria"], "exact_disk")["holds"], answer.code == 0)
                if answer.code == 0:
                    self.assertIsNone(result["counterexample"])
                else:
                    for key in ("inertia", "stiffness", "spectral_radius", "frequency_hz"):
                        self.assertIsInstance(result["counterexample"][key], (int, float), key)

    def test_the_textbook_allows_half_a_newton_metre_and_the_disk_seven_times_less(self):
        criteria = self.ask("passivity", RC_DISPLAY)["criteria"]
        self.assertAlmostEqual(named(criteria, "frequency_dependent")["max_stiffness"], 0.500, delta=0.0005)
        self.assertAlmostEqual(named(criteria, "exact_disk")["max_stiffness"], 0.0658, delta=0.005 * 0.0658)
        self.assertFalse(named(criteria, "frequency_dependent")["applies"])

    def test_an_ideal_path_would_allow_seven_times_more(self):
        criteria = self.ask("passivity", IDEAL_PATH)["criteria"]
        self.assertAlmostEqual(named(criteria, "exact_disk")["max_stiffness"], 0.468, delta=0.005 * 0.468)

    def test_just_above_the_limit_an_operator_breaks_the_loop(self):
        name = self.wall(1.03 * self.limit())
        answer = self.run_program("passivity", name, "--simulate-counterexample", "--json")
        self.assertEqual(answer.code, 1, answer)
        found = answer.json["counterexample"]
        self.assertGreater(found["spectral_radius"], 1)
        self.assertEqual(found["simulation"]["classification"], "diverges")
        self.assertEqual(len(found["simulation"]["time_s"]), len(found["simulation"]["position"]))

    def test_just_below_the_limit_the_loop_is_passive(self):
        answer = self.run_program("passivity", self.wall(0.97 * self.limit()), "--json")
        self.assertEqual((answer.code, answer.json["verdict"], answer.json["counterexample"]),
                         (0, "passive", None))

    def test_the_counterexample_makes_the_models_own_loop_diverge(self):
        found = self.ask("passivity", RC_DISPLAY)["counterexample"]
        self.assertEqual(found["resonators"], [], "this test holds one inertia and one spring only")
        model = with_value(load_example(), "/operator",
                           {"kind": "mass_spring_damper", "inertia": found["inertia"],
                            "stiffness": found["stiffness"]})
        run = self.ask("simulate", self.write_model(model), "--duration", "4 s")
        self.assertEqual(run["classification"], "diverges")
        # 4000 samples at the spectral radius, but for the beat of the oscillation.
        growth = math.log(max(map(abs, run["trace"]["position"][-200:])) /
                          max(map(abs, run["trace"]["position"][:200])))
        self.assertAlmostEqual(growth / (3800 * math.log(found["spectral_radius"])), 1, delta=0.1)

    def test_the_extra_damping_it_asks_for_is_enough_and_not_too_much(self):
        asked = self.ask("passivity", RC_DISPLAY)["extra_damping"]
        for part, code in ((0.98, 1), (1.02, 0)):
            model = with_value(load_example(), "/mechanics/damping", 1e-4 + part * asked)
            self.assertEqual(self.run_program("passivity", self.write_model(model)).code, code, part)

    def test_the_text_says_the_verdict_first_and_the_numbers_of_the_json(self):
        text = self.run_program("passivity", RC_DISPLAY).out
        self.assertTrue(text.startswith("RC-damped rotary display: NOT PASSIVE\n"), text)
        self.assertIn("65.7702 mN.m/rad", text)
        self.assertIn("Counterexample:", text)
        self.assertIn(": PASSIVE\n", self.run_program("passivity", IDEAL_PATH).out)

    def test_the_csv_holds_damping_over_frequency(self):
        curves = self.ask("passivity", RC_DISPLAY, "--csv", "b.csv")["damping_over_frequency"]
        self.assertEqual(column(self.folder / "b.csv", "frequency_hz"), curves["frequency_hz"])
        self.assertEqual(column(self.folder / "b.csv", "exact"), curves["exact"])
        self.assertLess(min(curves["exact"]), 0)


class ZwidthTest(ProgramTest):

    def test_the_answer_has_damping_stiffness_and_criterion(self):
        answer = self.ask("zwidth", RC_DISPLAY, "--damping", "0,1e-4,0.15 mN.m.s/rad", "--criterion", "exact_disk")
        self.assertEqual(answer["damping"], [0, 1e-4, 1.5e-4])
        self.assertEqual(answer["criterion"], "exact_disk")
        self.assertEqual(len(answer["max_stiffness"]), 3)

    def test_the_limits_of_both_criteria_at_the_headline_damping(self):
        for criterion, limit in (("frequency_dependent", 0.500), ("exact_disk", 0.0658)):
            answer = self.ask("zwidth", RC_DISPLAY, "--damping", "1.5e-4", "--criterion", criterion)
            self.assertAlmostEqual(answer["max_stiffness"][0] / limit, 1, delta=0.005, msg=criterion)
        answer = self.ask("zwidth", IDEAL_PATH, "--damping", "1.5e-4", "--criterion", "exact_disk")
        self.assertAlmostEqual(answer["max_stiffness"][0] / 0.468, 1, delta=0.005)

    def test_it_agrees_with_the_limit_that_passivity_names(self):
        for model in example_models():
            result = self.ask("passivity", model)
            name = self.ask("zwidth", model, "--damping", repr(result["virtual_damping"]))
            for boundary in name["boundaries"]:
                limit = named(result["criteria"], boundary["criterion"])["max_stiffness"]
                with self.subTest(model=model.name, criterion=boundary["criterion"]):
                    found = boundary["max_stiffness"][0]
                    if limit is None or found is None:  # unbounded, of one as of the other
                        self.assertEqual(found, limit)
                    else:
                        self.assertAlmostEqual(found, limit, delta=1e-6 * abs(limit))

    def test_several_criteria_come_in_the_order_asked_for(self):
        asked = ["coupled", "spring_damper", "exact_disk", "frequency_dependent"]
        answer = self.ask("zwidth", RC_DISPLAY, "--damping", "0", "--criterion", ",".join(asked))
        self.assertEqual([b["criterion"] for b in answer["boundaries"]], asked)
        self.assertEqual(answer["criterion"], "coupled")

    def test_the_coupled_limit_is_where_the_simulated_loop_turns(self):
        limit = self.ask("zwidth", RC_DISPLAY, "--damping", "1.5e-4", "--criterion", "coupled")["max_stiffness"][0]
        for part, expected in ((0.97, "settles"), (1.03, "diverges")):
            name = self.write_model(with_value(load_example(), "/controller/stiffness", part * limit))
            self.assertEqual(self.ask("simulate", name, "--duration", "10 s")["classification"], expected)

    def test_a_range_has_its_points_and_both_ends(self):
        answer = self.ask("zwidth", RC_DISPLAY, "--from", "0", "--to", "1e-4", "--points", "5")
        self.assertEqual([round(b, 12) for b in answer["damping"]], [0, 2.5e-5, 5e-5, 7.5e-5, 1e-4])

    def test_the_csv_has_a_column_for_every_criterion(self):
        answer = self.ask("zwidth", RC_DISPLAY, "--damping", "0,1e-4", "--csv", "k.csv")
        names, rows = read_csv(self.folder / "k.csv")
        self.assertEqual(names, ["damping"] + ["max_stiffness_" + b["criterion"] for b in answer["boundaries"]])
        self.assertEqual(len(rows), 2)
        self.assertEqual(column(self.folder / "k.csv", names[1]), answer["max_stiffness"])


class SimulateTest(ProgramTest):

    def test_the_answer_has_time_steps_classification_and_ledger(self):
        answer = self.ask("simulate", RC_DISPLAY)
        self.assertEqual((answer["final_time_s"], answer["steps"]), (0.5, 500))
        self.assertIn(answer["classification"], ("settles", "limit_cycle", "diverges"))
        for key in ("operator", "source", "stored", "dissipated", "residual"):
            self.assertIsInstance(answer["energy"][key], float, key)

    def test_the_csv_has_one_row_per_sample_instant(self):
        for model in example_models():
            self.ask("simulate", model, "--csv", "trace.csv", "--duration", "0.2 s")
            names, rows = read_csv(self.folder / "trace.csv")
            with self.subTest(model=model.name):
                self.assertEqual(names[:5], ["time_s", "position", "velocity", "effort", "command"])
                if "motor" in json.loads(model.read_text()):
                    self.assertEqual(names[5], "current")
                self.assertEqual([float(row[0]) for row in rows], [k * 1 / 1000 for k in range(201)])
                self.assertTrue(all(len(row) == len(names) for row in rows))

    def test_the_numbers_in_the_csv_round_trip(self):
        answer = self.ask("simulate", RE35, "--csv", "trace.csv")
        names, rows = read_csv(self.folder / "trace.csv")
        for row in rows:
            for text in row:
                self.assertEqual(f"{float(text):.17g}", text)
        for name in ("time_s", "position", "velocity", "current"):
            self.assertEqual(column(self.folder / "trace.csv", name), answer["trace"][name], name)

    def test_the_run_starts_from_the_initial_conditions(self):
        trace = self.ask("simulate", RE35)["trace"]
        self.assertAlmostEqual(trace["position"][0], -0.05, delta=1e-15)
        self.assertAlmostEqual(trace["velocity"][0], 2, delta=1e-14)

    def test_a_trace_step_adds_rows_in_between_and_moves_none(self):
        for model in (RC_DISPLAY, RE35):
            self.ask("simulate", model, "--duration", "20 ms", "--csv", "samples.csv")
            self.ask("simulate", model, "--duration", "20 ms", "--csv", "trace.csv", "--trace-step", "10us")
            time_s = column(self.folder / "trace.csv", "time_s")
            with self.subTest(model=model.name):
                self.assertEqual(time_s, sorted(time_s))
                self.assertEqual(sorted({round(t * 1e5) for t in time_s}), list(range(2001)))
                # Beside the steps at most the hold's edge, before and after, in each of 20 periods.
                self.assertLessEqual(len(time_s), 2001 + 2 * 20)
                samples = dict(zip(column(self.folder / "samples.csv", "time_s"),
                                   column(self.folder / "samples.csv", "position")))
                dense = dict(zip(time_s, column(self.folder / "trace.csv", "position")))
                for t, position in samples.items():
                    self.assertAlmostEqual(dense[t], position, delta=1e-12)

    def test_a_trace_step_that_does_not_divide_the_period_keeps_the_sample_instants(self):
        self.ask("simulate", RC_DISPLAY, "--duration", "5 ms", "--csv", "trace.csv", "--trace-step", "0.3 ms")
        time_s = [round(t * 1e4) for t in column(self.folder / "trace.csv", "time_s")]
        self.assertEqual(time_s, sorted(set(range(0, 51, 3)) | set(range(0, 51, 10))))

    def test_the_three_engines_agree_on_every_example(self):
        for model in example_models():
            runs = {engine: self.ask("simulate", model, "--engine", engine) for engine in engines_for(model)}
            exact = runs["exact"]["trace"]["position"]
            largest = max(map(abs, exact))
            self.assertGreater(largest, 0)
            for engine, run in runs.items():
                with self.subTest(model=model.name, engine=engine):
                    self.assertEqual(run["engine"], engine)
                    self.assertEqual(len(run["trace"]["position"]), len(exact))
                    error = max(abs(a - b) for a, b in zip(run["trace"]["position"], exact))
                    self.assertLess(error, 1e-6 * largest)
                    self.assertEqual(run["classification"], runs["exact"]["classification"])

    def test_the_ledger_balances_with_every_engine_on_every_example(self):
        for model in example_models():
            for engine in engines_for(model):
                energy = self.ask("simulate", model, "--engine", engine)["energy"]
                moved = sum(abs(energy[k]) for k in ("operator", "source", "dissipated", "stored_initially"))
                with self.subTest(model=model.name, engine=engine):
                    self.assertGreater(energy["dissipated"], 0)
                    self.assertLess(abs(energy["residual"]), 1e-6 * moved)
                    balance = (energy["operator"] + energy["source"] - energy["dissipated"] -
                               energy["stored"] + energy["stored_initially"])
                    self.assertAlmostEqual(balance, energy["residual"], delta=1e-12 * moved)

    def test_the_same_run_twice_gives_the_same_bytes(self):
        for engine in ENGINES:
            kept = []
            for _ in range(2):
                answer = self.run_program("simulate", RE35, "--engine", engine, "--json", "--csv", "trace.csv",
                                          "-o", "result.json")
                kept.append((answer.out, (self.folder / "trace.csv").read_bytes(),
                             (self.folder / "result.json").read_bytes()))
            with self.subTest(engine=engine):
                self.assertEqual(kept[0], kept[1])

    def test_a_duration_option_overrides_the_models(self):
        answer = self.ask("simulate", RC_DISPLAY, "--duration", "123 ms")
        self.assertEqual((answer["final_time_s"], answer["steps"]), (0.123, 123))

    def test_a_stable_loop_is_never_said_to_diverge_however_short_the_run(self):
        radius = self.ask("passivity", RC_DISPLAY, "--no-counterexample")["uncoupled_spectral_radius"]
        self.assertLess(radius, 1)
        for duration in ("0.05 s", "0.1 s", "0.2 s", "0.3 s", "1 s"):
            answer = self.ask("simulate", RC_DISPLAY, "--duration", duration)
            with self.subTest(duration=duration):
                self.assertNotEqual(answer["classification"], "diverges")

    def test_a_sensed_position_is_the_nearest_multiple_halves_up_plus_offset(self):
        model = with_value(load_example(), "/sensor", {"quantum": 1e-3, "offset": 0.25})
        for steps in (-2.5, -0.5, -0.4, 0.5, 0.6, 1.5):
            model = with_value(model, "/simulation", {"duration": "2 ms", "initial_position": steps * 1e-3})
            trace = self.ask("simulate", self.write_model(model))["trace"]
            with self.subTest(steps=steps):
                self.assertAlmostEqual(trace["measured_position"][0], 0.25 + 1e-3 * math.floor(steps + 0.5),
                                       delta=1e-12)


class ProgressTest(ProgramTest):
    """A command that takes over a second shows how far it is, where stderr is a terminal."""

    LONG = {"zwidth": ["zwidth", RC_DISPLAY, "--points", "300000"],
            "simulate": ["simulate", RC_DISPLAY, "--engine", "cvode", "--duration", "2000 s"]}

    def start_on_a_terminal(self, arguments):
        leader, follower = pty.openpty()
        process = subprocess.Popen([program(), *map(str, arguments)], cwd=self.folder, stderr=follower,
                                   stdout=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
        os.close(follower)
        os.set_blocking(leader, False)
        self.addCleanup(os.close, leader)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process, leader

    def test_a_long_command_shows_part_rate_and_time_left(self):
        for name, arguments in self.LONG.items():
            with self.subTest(name):
                process, leader = self.start_on_a_terminal(arguments)
                shown = self.read_until(r"\d %.*/s.*left", process, leader)
                self.assertRegex(shown, r"\d %.*/s.*left")
                self.assertIsNone(process.poll(), "over before a progress bar was due")
                process.kill()

    def read_until(self, pattern, process, leader):
        """What was shown up to the pattern. A bar is due after a second of work, however long the
        machine, which may be busy with more than this test, takes to come to it."""
        shown = ""
        patience = time.monotonic() + PATIENCE_S
        while time.monotonic() < patience and not re.search(pattern, shown):
            over = process.poll() is not None
            try:
                shown += os.read(leader, 65536).decode()
            except OSError:  # nothing was written since
                if over:
                    break
                time.sleep(0.05)
        return shown

    def test_a_short_command_shows_none(self):
        process, leader = self.start_on_a_terminal(["impedance", RC_DISPLAY, "--frequency", "1"])
        process.wait(PATIENCE_S)
        self.assertEqual(self.read_until("%", process, leader), "")


if __name__ == "__main__":
    unittest.main()
