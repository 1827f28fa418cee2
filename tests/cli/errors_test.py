"""Bad input and numerical failure: exit code, silence on stdout, and a message that helps."""
import json
import math
import os
import unittest

from program import MODEL_COMMANDS, RC_DISPLAY, ROOT, ProgramTest, load_example, with_value, without

# One frequency, one damping: the quickest form of each command.
QUICK = {"impedance": ["--frequency", "1"], "zwidth": ["--damping", "0"],
         "passivity": ["--no-counterexample"], "simulate": []}


class ModelErrorTest(ProgramTest):

    def assert_all_commands_refuse(self, model, *fragments):
        name = self.write_model(model)
        for command in MODEL_COMMANDS:
            answer = self.run_program(command, name, *QUICK[command])
            with self.subTest(command=command, expected=fragments):
                self.assert_refused(answer, *fragments)
                self.assertTrue(answer.err.startswith(f"gyrator: {name}: "), answer)

    def assert_value_refused(self, path, value, *fragments):
        """The message names the JSON path first, then what was found and what is allowed."""
        self.assert_all_commands_refuse(with_value(load_example(), path, value),
                                        f"model.json: {path}: ", *fragments)


class ValueTest(ModelErrorTest):

    def test_a_negative_value_where_none_can_be_is_refused_with_the_bound(self):
        for path, bound in {"/motor/resistance": "above 0 ohm", "/motor/inductance": "at least 0 H",
                            "/motor/torque_constant": "above 0 N.m/A",
                            "/mechanics/inertia": "above 0 kg.m^2",
                            "/mechanics/damping": "at least 0 N.m.s/rad",
                            "/mechanics/coulomb_friction": "at least 0 N.m",
                            "/damping/0/resistance": "at least 0 ohm",
                            "/damping/0/capacitance": "above 0 F",
                            "/sensor/quantum": "at least 0 rad", "/sampling/period": "above 0 s",
                            "/sampling/delay": "at least 0 s",
                            "/controller/stiffness": "at least 0 N.m/rad",
                            "/simulation/duration": "above 0 s"}.items():
            self.assert_value_refused(path, -1.5, "-1.5", bound)

    def test_zero_where_none_can_be_is_refused_with_the_bound(self):
        for path, bound in {"/motor/resistance": "above 0 ohm",
                            "/motor/torque_constant": "above 0 N.m/A",
                            "/mechanics/inertia": "above 0 kg.m^2",
                            "/damping/0/capacitance": "above 0 F",
                            "/sampling/period": "above 0 s",
                            "/simulation/duration": "above 0 s"}.items():
            self.assert_value_refused(path, 0, ": 0 ", bound)
        self.assert_value_refused("/controller/velocity/window", 0, ": 0: ", "at least 1")
        self.assert_value_refused("/sensor/quantum", "0 counts/rev", "0 counts/rev", "above 0")

    def test_not_a_number_and_infinity_are_refused_as_texts(self):
        for text in ("NaN", "nan ohm", "inf", "-Infinity", "1e400 ohm"):
            self.assert_value_refused("/motor/resistance", text, text.strip("-"))

    def test_not_a_number_as_python_writes_it_is_refused_with_its_path(self):
        for value in (float("nan"), float("inf")):
            written = "NaN" if value != value else "Infinity"
            self.assert_all_commands_refuse(with_value(load_example(), "/motor/resistance", value),
                                            "/motor/resistance", written)

    def test_a_unit_of_another_dimension_is_refused_with_both_dimensions(self):
        self.assert_value_refused("/motor/resistance", "1.5 V", "'1.5 V'", "a voltage", "a resistance",
                                  "ohm")
        self.assert_value_refused("/motor/torque_constant", "50 mN.m", "a torque [N.m]",
                                  "a torque constant [N.m/A]")
        self.assert_value_refused("/mechanics/damping", "1e-4 N.s/m", "a linear damping",
                                  "a rotary damping [N.m.s/rad]")
        self.assert_value_refused("/controller/stiffness", "0.4 N/m", "a linear stiffness",
                                  "a rotary stiffness [N.m/rad]")
        self.assert_value_refused("/sensor/quantum", "1 mm", "a length", "counts/rev")
        self.assert_value_refused("/sampling/period", "1 kHz", "'kHz'", "unit of time", "ms")

    def test_an_unknown_unit_is_refused_with_the_nearest_one(self):
        self.assert_value_refused("/motor/resistance", "1.5 ohmz", "'ohmz'", "did you mean 'ohm'?")
        self.assert_value_refused("/motor/inductance", "0.5 mh", "'mh'", "did you mean 'mH'?")
        self.assert_value_refused("/damping/0/capacitance", "2200 uf", "did you mean 'uF'?")
        self.assert_value_refused("/motor/torque_constant", "50 mNm/A", "did you mean 'mN.m'?")

    def test_a_newton_metre_without_a_dot_is_not_taken_for_a_nanometre(self):
        self.assert_value_refused("/controller/stiffness", "0.4 Nm/rad", "did you mean 'N.m'?")

    def test_a_decimal_comma_is_refused_with_the_point(self):
        self.assert_value_refused("/motor/resistance", "1,5 ohm", "'1,5 ohm'", "comma", "1.5 ohm")

    def test_a_value_of_another_type_is_refused_with_what_was_found(self):
        for value, found in ((None, "null"), (True, "true"), ([1], "a list of 1"), ({}, "an object")):
            self.assert_value_refused("/motor/resistance", value, f"found {found}", "a resistance [ohm]")
        self.assert_value_refused("/controller/unilateral", "true", 'the text "true"', "true or false")
        self.assert_value_refused("/controller/velocity", "difference", 'the text "difference"',
                                  '{"kind": "difference"}')
        self.assert_value_refused("/damping", {"kind": "rc"}, "found an object", "a list")
        self.assert_value_refused("/name", 5, "the number 5", "a text")

    def test_an_item_of_a_list_is_not_asked_to_be_a_list_itself(self):
        model = with_value(load_example(), "/damping", [3])
        answer = self.run_program("passivity", self.write_model(model))
        self.assert_refused(answer, "model.json: /damping/0: found the number 3", "resistor, rc")
        self.assertNotIn("a list", answer.err)

    def test_a_number_that_another_program_wrote_in_full_is_taken(self):
        # json.dumps(1 / 3000) is 0.0003333333333333333; 1e-4 in steps is 9.999999999999999e-05.
        for period in (1 / 3000, 1 / 7000, 9.999999999999999e-05):
            name = self.write_model(with_value(load_example(), "/sampling/period", period))
            answer = self.run_program("impedance", name, "--frequency", "1", "--json")
            with self.subTest(period=period):
                self.assertEqual(answer.code, 0, answer)
                self.assertEqual(answer.json["model"]["sampling"]["period"], period)

    def test_a_delay_beyond_all_sense_is_answered_or_refused_by_name(self):
        name = self.write_model(with_value(load_example(), "/sampling/delay", "1000 s"))
        answer = self.run_program("passivity", name, "--no-counterexample")
        if answer.code == 2:
            self.assert_refused(answer, "model.json: /sampling/delay: ")
        else:
            self.assertIn(answer.code, (0, 1), answer)
            self.assertIn("PASSIVE", answer.out)


class KeyTest(ModelErrorTest):

    def test_an_unknown_key_is_refused_with_the_allowed_and_the_nearest(self):
        base = load_example()
        for path, known, nearest in (("/mototr", "sampling", "motor"),
                                     ("/motor/resistence", "torque_constant", "resistance"),
                                     ("/amplifier/bandwith", "sense", "bandwidth"),
                                     ("/controller/stifness", "unilateral", "stiffness"),
                                     ("/damping/0/capacitence", "resistance", "capacitance"),
                                     ("/simulation/initial_velcoity", "duration", "initial_velocity")):
            self.assert_all_commands_refuse(with_value(base, path, 1), f"model.json: {path}: ",
                                            f"unknown key '{path.split('/')[-1]}'", "allowed", known,
                                            f"did you mean '{nearest}'?")

    def test_a_key_of_another_kind_is_refused_with_its_owner(self):
        model = with_value(load_example(), "/amplifier/output_resistance", 1)
        self.assert_all_commands_refuse(model, "/amplifier/output_resistance", "'current'", "'voltage'",
                                        "bandwidth")

    def test_a_key_of_the_other_motion_is_refused_with_this_motions_name(self):
        self.assert_all_commands_refuse(with_value(load_example(), "/motion", "linear"),
                                        "/motor/torque_constant", "did you mean 'force_constant'?")

    def test_an_unknown_kind_or_name_is_refused_with_the_allowed_and_the_nearest(self):
        for path, typo, known, nearest in (("/motion", "rotory", "linear", "rotary"),
                                           ("/amplifier/kind", "voltge", "ideal", "voltage"),
                                           ("/amplifier/sense", "motr", "total", "motor"),
                                           ("/damping/0/kind", "rcc", "resistor", "rc"),
                                           ("/controller/kind", "virtual_wal", "none", "virtual_wall"),
                                           ("/controller/velocity/kind", "diference",
                                            "filtered_difference", "difference"),
                                           ("/operator/kind", "fre", "clamped", "free"),
                                           ("/schema", "gyrator/modle/1", "allowed", "gyrator/model/1")):
            self.assert_value_refused(path, typo, f"'{typo}'", "allowed", known,
                                      f"did you mean '{nearest}'?")

    def test_a_velocity_estimator_that_cannot_be_is_refused_with_what_can(self):
        for estimator, key, expected in (
                ({"kind": "butterworth", "cutoff": "50 Hz", "order": 0}, "order", "at least 1 and at most 8"),
                ({"kind": "butterworth", "cutoff": "50 Hz", "order": 9}, "order", "at least 1 and at most 8"),
                ({"kind": "butterworth", "cutoff": "600 Hz"}, "cutoff", "below 500 Hz, the Nyquist frequency"),
                ({"kind": "foaw"}, "noise", "the sensor a quantum"),
                ({"kind": "foaw", "noise": 0}, "noise", "above 0 rad"),
                ({"kind": "foaw", "noise": "1 mm"}, "noise", "an angle [rad] is expected"),
                ({"kind": "foaw", "noise": 1e-3, "max_window": 0}, "max_window", "at least 1"),
                ({"kind": "foaw", "noise": 1e-3, "fit": "both"}, "fit", "best, end"),
                ({"kind": "levant", "acceleration_bound": 0}, "acceleration_bound", "above 0 rad/s^2"),
                ({"kind": "levant", "acceleration_bound": 9, "sign_gain": 1}, "sign_gain", "above 1")):
            self.assert_all_commands_refuse(with_value(load_example(), "/controller/velocity", estimator),
                                            f"model.json: /controller/velocity/{key}: ", expected)

    def test_criteria_refuse_an_estimator_that_is_not_linear_and_name_those_that_are(self):
        for estimator in ({"kind": "foaw", "noise": 1e-3}, {"kind": "levant", "acceleration_bound": 100}):
            for damping in (1e-4, 0):
                model = with_value(load_example(), "/controller/velocity", estimator)
                name = self.write_model(with_value(model, "/controller/damping", damping))
                for arguments in (["passivity", name], ["zwidth", name], ["zwidth", name, "--damping", "0"],
                                  ["compare", name, name]):
                    with self.subTest(arguments=arguments, estimator=estimator, damping=damping):
                        self.assert_refused(self.run_program(*arguments),
                                            f"{name}: /controller/velocity/kind: \"{estimator['kind']}\"",
                                            "not linear", "\"butterworth\"", "simulate")
                for arguments in (["impedance", name], ["simulate", name]):
                    self.assertEqual(self.run_program(*arguments).code, 0)

    def test_the_noise_of_an_adaptive_window_is_the_sensors_quantum_unless_given(self):
        quantum = "8192 counts/rev"
        model = with_value(load_example(), "/sensor/quantum", quantum)
        runs = {}
        for label, noise in (("absent", {}), ("the quantum", {"noise": 2 * math.pi / 8192}), ("more", {"noise": 0.01})):
            name = self.write_model(with_value(model, "/controller/velocity", {"kind": "foaw", **noise}))
            answer = self.run_program("simulate", name, "--json")
            self.assertEqual(answer.code, 0, answer)
            runs[label] = answer.json["energy"]
        self.assertEqual(runs["absent"], runs["the quantum"])
        self.assertNotEqual(runs["absent"], runs["more"])

    def test_a_missing_member_is_refused_with_its_name_and_unit(self):
        base = load_example()
        for path, expected in (("/motor/resistance", "a resistance [ohm]"),
                               ("/damping/0/capacitance", "a capacitance [F]"),
                               ("/sampling/period", "a time [s]"),
                               ("/controller/stiffness", "a rotary stiffness [N.m/rad]"),
                               ("/mechanics", "inertia"), ("/sampling", "period"),
                               ("/motion", "rotary, linear"), ("/controller/kind", "virtual_wall"),
                               ("/damping/0/kind", "resistor, rc")):
            parent, _, key = path.rpartition("/")
            self.assert_all_commands_refuse(without(base, path), f"model.json: {parent or '/'}: ",
                                            f"'{key}' is missing", expected)

    def test_an_amplifier_without_a_motor_is_refused_with_the_remedy(self):
        self.assert_all_commands_refuse(without(load_example(), "/motor"), "model.json: /motor: ",
                                        '"kind": "ideal"')

    def test_a_key_given_twice_is_refused(self):
        self.assert_all_commands_refuse('{"motion": "rotary", "motion": "linear"}', "/motion", "twice")


class FileTest(ModelErrorTest):

    def test_a_file_cut_off_anywhere_is_refused_with_line_and_column(self):
        text = RC_DISPLAY.read_bytes().strip()
        for length in range(1, len(text), len(text) // 12):
            name = self.write_model(text[:length])
            answer = self.run_program("passivity", name)
            with self.subTest(length=length):
                self.assert_refused(answer, f"gyrator: {name}: line ", "column ", "^")

    def test_an_empty_file_is_refused(self):
        for content in (b"", b" \n\t\n"):
            self.assert_all_commands_refuse(content, "is empty", "a JSON object")

    def test_a_binary_file_is_refused(self):
        self.assert_all_commands_refuse(b"\x7fELF\x02\x01\x01\0\0\0", "zero byte at offset 7")
        self.assert_all_commands_refuse(b"\x89PNG\r\n\x1a\n", "byte 0x89 at offset 0", "UTF-8")
        self.assert_all_commands_refuse(json.dumps(load_example()).encode("utf-16"), "UTF-16")

    def test_a_deeply_nested_file_is_refused_without_overflowing_the_stack(self):
        for content in (b"[" * 200000, b'{"a":' * 200000, b'{"damping":' + b"[" * 99 + b"]" * 99 + b"}"):
            self.assert_all_commands_refuse(content, "nested deeper than 64")

    def test_json_that_is_no_object_is_refused(self):
        for content, found in (("[]", "a list of 0"), ("3", "the number 3"), ("null", "null"),
                               ('"x"', 'the text "x"')):
            self.assert_all_commands_refuse(content, "model.json: /: ", f"found {found}", "an object")

    def test_a_comment_or_a_trailing_comma_is_refused_with_its_place(self):
        self.assert_all_commands_refuse('{\n  "motion": "rotary",\n}', "line 3, column 1")
        self.assert_all_commands_refuse('{\n  // wall\n  "motion": "rotary"}', "line 2, column 3")

    def test_a_missing_file_is_refused_with_the_nearest_name(self):
        self.write_model(load_example(), "device.json")
        for command in MODEL_COMMANDS + ("report", "schematic"):
            with self.subTest(command=command):
                self.assert_refused(self.run_program(command, "devcie.json"), "gyrator: devcie.json: ",
                                    "no such file", "did you mean 'device.json'?")

    def test_a_folder_in_place_of_a_file_is_refused(self):
        for command in MODEL_COMMANDS + ("report", "schematic"):
            with self.subTest(command=command):
                self.assert_refused(self.run_program(command, "."), "is a folder")

    def test_a_missing_folder_is_named(self):
        self.assert_refused(self.run_program("passivity", "models/device.json"), "models/device.json",
                            "no folder 'models'")

    def test_a_file_name_that_is_no_utf8_is_read_all_the_same(self):
        name = os.fsencode(self.folder) + b"/device\xff.json"
        with open(name, "wb") as file:
            file.write(RC_DISPLAY.read_bytes())
        answer = self.run_program("impedance", b"device\xff.json", "--frequency", "1", "--json")
        self.assertEqual(answer.code, 0, answer)
        self.assertEqual(answer.json["model_name"], "RC-damped rotary display")

    def test_a_model_file_handed_to_report_is_refused_with_the_remedy(self):
        self.assert_refused(self.run_program("report", RC_DISPLAY), str(RC_DISPLAY), "is not a result", "-o")

    def test_a_broken_result_handed_to_report_is_refused_with_its_file(self):
        for content, path in (('{"command": "passivity"}', "/criteria"),
                              ('{"command": "simulate", "trace": 3}', "/trace"),
                              ('{"command": "hello"}', "/command")):
            name = self.write_model(content, "result.json")
            answer = self.run_program("report", name, "-o", "page.html")
            with self.subTest(content=content):
                self.assert_refused(answer, path, "result.json")
        self.assertEqual(self.files(), ["result.json"])


class SimulateInputTest(ProgramTest):
    """What only `simulate` cannot take is refused in the same words as everything else."""

    def test_friction_and_stops_that_contradict_themselves_are_refused_with_file_and_path(self):
        stops = {"lower": 0.2, "upper": 0.1, "stiffness": 5}
        for path, value, what in (
                ("/mechanics/stiction", 1e-3, "at least coulomb_friction"),
                ("/mechanics/stribeck_velocity", 0.1, "give a stiction above"),
                ("/mechanics/stops", {"stiffness": 5}, "at least one"),
                ("/mechanics/stops", stops, "must be above"),
                ("/mechanics/stops", {"upper": 0.1}, "stiffness")):
            model = with_value(load_example(), "/mechanics/coulomb_friction", 2e-3)
            name = self.write_model(with_value(model, path, value))
            with self.subTest(path=path, value=value):
                self.assert_refused(self.run_program("simulate", name), what)
                self.assert_refused(self.run_program("passivity", name), "model.json: " + path)

    def test_friction_is_not_for_odeint(self):
        name = self.write_model(with_value(load_example(), "/mechanics/coulomb_friction", 1e-3))
        self.assert_refused(self.run_program("simulate", name, "--engine", "odeint"), "--engine", "exact or cvode")

    def test_a_duration_below_one_period_is_refused_with_file_and_path(self):
        name = self.write_model(with_value(load_example(), "/simulation/duration", "0.1 ms"))
        self.assert_refused(self.run_program("simulate", name), "one sample period")
        self.assert_refused(self.run_program("simulate", name), "model.json: /simulation/duration: ")

    def test_a_duration_option_below_one_period_is_refused_by_the_options_name(self):
        self.assert_refused(self.run_program("simulate", RC_DISPLAY, "--duration", "0.1 ms"), "--duration")

    def test_a_run_too_long_for_the_memory_is_refused_by_name(self):
        answer = self.run_program("simulate", RC_DISPLAY, "--duration", "1e9 s", timeout=5)
        self.assert_refused(answer, "--duration")


class OptionTest(ProgramTest):

    def refuse(self, arguments, *fragments):
        answer = self.run_program(*arguments)
        with self.subTest(arguments=" ".join(map(str, arguments))):
            self.assert_refused(answer, *fragments)

    def test_no_command_at_all_is_refused(self):
        self.refuse([], "--help")

    def test_a_missing_model_is_refused(self):
        for command in MODEL_COMMANDS:
            self.refuse([command], "MODEL")

    def test_an_unknown_command_is_refused_with_the_nearest(self):
        self.refuse(["passivty", RC_DISPLAY], "passivty")
        self.refuse(["passivty", RC_DISPLAY], "did you mean 'passivity'?")

    def test_an_unknown_option_is_refused_by_name(self):
        for command in MODEL_COMMANDS:
            self.refuse([command, RC_DISPLAY, "--colour"], "--colour")

    def test_a_mistyped_option_is_refused_with_the_nearest(self):
        self.refuse(["passivity", RC_DISPLAY, "--jsn"], "'--json'")
        self.refuse(["zwidth", RC_DISPLAY, "--criteron", "coupled"], "'--criterion'")

    def test_a_mistyped_engine_is_refused_with_the_allowed(self):
        self.refuse(["simulate", RC_DISPLAY, "--engine", "cvod"], "--engine", "cvod", "exact", "odeint")

    def test_a_mistyped_engine_is_refused_with_the_nearest(self):
        self.refuse(["simulate", RC_DISPLAY, "--engine", "cvod"], "did you mean")

    def test_a_mistyped_criterion_is_refused_with_the_allowed_and_the_nearest(self):
        self.refuse(["zwidth", RC_DISPLAY, "--criterion", "exact_dsk"], "--criterion", "exact_dsk", "coupled",
                    "spring_damper", "did you mean", "exact_disk")
        self.refuse(["zwidth", RC_DISPLAY, "--criterion", "coupled,exakt_disk"], "exakt_disk", "did you mean")

    def test_points_that_are_negative_too_few_or_no_number_are_refused(self):
        for command in ("impedance", "zwidth"):
            for points in ("-3", "0", "1", "2.5", "many"):
                self.refuse([command, RC_DISPLAY, "--points", points], "--points", points)

    def test_a_quantity_option_of_another_dimension_is_refused_with_both(self):
        self.refuse(["zwidth", RC_DISPLAY, "--damping", "0,5 kg"], "--damping", "'5 kg'", "a mass",
                    "a rotary damping [N.m.s/rad]")
        self.refuse(["impedance", RC_DISPLAY, "--frequency", "1 s"], "--frequency", "a time", "a frequency [Hz]")
        self.refuse(["impedance", RC_DISPLAY, "--from", "1 V"], "--from", "a voltage", "a frequency [Hz]")
        self.refuse(["simulate", RC_DISPLAY, "--duration", "1 V"], "--duration", "'V'", "ms")
        self.refuse(["simulate", RC_DISPLAY, "--trace-step", "1 rad"], "--trace-step", "'rad'", "us")

    def test_a_quantity_option_that_is_no_number_is_refused(self):
        self.refuse(["zwidth", RC_DISPLAY, "--damping", "nan"], "--damping", "'nan'", "finite")
        self.refuse(["zwidth", RC_DISPLAY, "--damping", "1e-4,,2e-4"], "--damping", "number is expected")
        self.refuse(["impedance", RC_DISPLAY, "--frequency", "1:10"], "--frequency", "1:10")
        self.refuse(["simulate", RC_DISPLAY, "--tolerance", "tight"], "--tolerance", "tight")

    def test_zero_and_negative_frequencies_and_times_are_refused(self):
        for value in ("0", "-1"):
            self.refuse(["impedance", RC_DISPLAY, "--frequency", value], "--frequency", value, "above 0 Hz")
            self.refuse(["impedance", RC_DISPLAY, "--from", value], "--from", value, "above 0 Hz")
            self.refuse(["simulate", RC_DISPLAY, "--duration", value], "--duration", value, "longer than 0 s")
            self.refuse(["simulate", RC_DISPLAY, "--trace-step", value], "--trace-step", value,
                        "longer than 0 s")

    def test_a_range_that_is_empty_or_has_one_end_is_refused(self):
        self.refuse(["impedance", RC_DISPLAY, "--from", "10", "--to", "1"], "--to", "above --from")
        self.refuse(["zwidth", RC_DISPLAY, "--from", "1e-4", "--to", "0"], "--to", "above --from")
        self.refuse(["zwidth", RC_DISPLAY, "--from", "0"], "--from", "--to")

    def test_an_option_with_an_empty_value_is_refused(self):
        self.refuse(["zwidth", RC_DISPLAY, "--damping", ""], "--damping")
        self.refuse(["impedance", RC_DISPLAY, "--frequency", ""], "--frequency")
        for option in ("-o", "--csv", "--svg", "--png"):
            self.refuse(["impedance", RC_DISPLAY, "--frequency", "1", option, ""], "empty")

    def test_a_step_limit_or_tolerance_out_of_range_is_refused(self):
        self.refuse(["simulate", RC_DISPLAY, "--max-steps", "0"], "--max-steps", "0")
        self.refuse(["simulate", RC_DISPLAY, "--tolerance", "1"], "--tolerance", "0.01")

    def test_help_is_there_for_everything_with_an_example(self):
        for command in MODEL_COMMANDS + ("report", "schematic", "schema"):
            answer = self.run_program(command, "--help")
            with self.subTest(command=command):
                self.assertEqual((answer.code, answer.err), (0, ""), answer)
                self.assertIn("Example:\n  gyrator " + ("passivity" if command == "report" else command),
                              answer.out)
                self.assertIn(f"  {command} ", self.run_program("--help").out)

    def test_the_version_is_one_line(self):
        answer = self.run_program("--version")
        self.assertRegex(answer.out, r"\Agyrator \d+\.\d+\.\d+\n\Z")
        self.assertEqual(answer.code, 0)


def oscillating_device():
    """A current amplifier that senses the motor's current, around a bare capacitor: it oscillates."""
    model = with_value(load_example(), "/amplifier",
                       {"kind": "current", "sense": "motor", "bandwidth": "20 kHz"})
    return with_value(model, "/damping/0/resistance", 0)


class DriveErrorTest(ModelErrorTest):
    """What makes no sense together in a drive is refused at its place, with what would."""

    CANCELLATION = {"kind": "resistance_cancellation", "fraction": 0.9}
    HELD = {"kind": "held_impedance"}

    def model(self, *damping, **changes):
        model = json.loads((ROOT / "docs/drives/models/resistance_cancellation.json").read_text())
        model.update({"damping": list(damping), **changes})
        return {key: value for key, value in model.items() if value is not None}

    def test_cancelling_more_than_the_loop_has_names_the_number_allowed(self):
        model = self.model({"kind": "resistance_cancellation", "resistance": "2.1 ohm"})
        self.assert_all_commands_refuse(model, "/damping/0: resistance_cancellation of 2.1 ohm",
                                        "winding of 2.06 ohm", "port clamped", "must be below 2.06 ohm for a clamped",
                                        "below 2.06027 ohm for a free port", "doubles every")
        model["amplifier"]["output_resistance"] = "0.1 ohm"
        self.assertEqual(self.run_program("impedance", self.write_model(model), "--frequency", "1").code, 0)

    def test_a_winding_too_cold_for_the_cancellation_is_named_with_its_temperature(self):
        model = with_value(self.model(self.CANCELLATION), "/motor/temperature_rise", "-30 K")
        self.assert_all_commands_refuse(model, "/damping/0", "1.854 ohm", "1.81713 ohm", "-30 K")
        model["motor"]["temperature_rise"] = "-25 K"
        self.assertEqual(self.run_program("impedance", self.write_model(model), "--frequency", "1").code, 0)

    def test_a_winding_colder_than_its_copper_allows_is_refused_at_the_temperature(self):
        model = with_value(self.model(self.CANCELLATION), "/motor/temperature_rise", "-300 K")
        self.assert_all_commands_refuse(model, "/motor/temperature_rise: -300 K", "above -254.453 K")

    def test_a_second_of_a_kind_that_acts_on_the_whole_drive_is_refused(self):
        current = {"kind": "current"}
        for damping, amplifier in ((self.CANCELLATION, {"kind": "voltage"}), (self.HELD, current),
                                   ({"kind": "back_emf", "damping": 1e-6}, current)):
            self.assert_all_commands_refuse(self.model(damping, damping, amplifier=amplifier),
                                            f"/damping/1: a second {damping['kind']}", "one at most")

    def test_cancellation_where_the_current_is_imposed_or_none_flows_is_refused_with_the_way_out(self):
        for kind, reason in (("current", "imposes the current"), ("ideal", "no current flows")):
            model = self.model(self.CANCELLATION, amplifier={"kind": kind})
            self.assert_all_commands_refuse(model, "/damping/0", reason, '{"kind": "voltage"}', "across the motor")
            model["damping"].append({"kind": "rc", "resistance": 5, "capacitance": 1e-3})
            answer = self.run_program("impedance", self.write_model(model), "--frequency", "1")
            self.assertEqual(answer.code, 0, answer)

    def test_a_fraction_and_a_resistance_or_neither_are_refused(self):
        both = {"kind": "resistance_cancellation", "fraction": 0.9, "resistance": 1}
        self.assert_all_commands_refuse(self.model(both), "/damping/0: resistance and fraction are given",
                                        "exactly one")
        self.assert_all_commands_refuse(self.model({"kind": "resistance_cancellation"}), "/damping/0: none is given",
                                        "exactly one", "resistance, fraction")

    def test_a_held_impedance_without_a_wall_or_with_a_one_sided_one_is_refused(self):
        current = {"kind": "current"}
        self.assert_all_commands_refuse(self.model(self.HELD, amplifier=current, controller={"kind": "none"}),
                                        "/damping", "held_impedance", "virtual_wall")
        wall = {"kind": "virtual_wall", "stiffness": 0.01, "unilateral": True}
        self.assert_all_commands_refuse(self.model(self.HELD, amplifier=current, controller=wall),
                                        "/controller/unilateral: true", "held_impedance", "linear")

    def test_a_circuit_without_a_motor_is_refused_and_a_damper_at_the_port_is_not(self):
        ideal = {"kind": "ideal"}
        for damping in ({"kind": "resistor", "resistance": 1}, {"kind": "rc", "resistance": 1, "capacitance": 1e-3},
                        self.CANCELLATION, {"kind": "back_emf", "damping": 1e-6}):
            self.assert_all_commands_refuse(self.model(damping, motor=None, amplifier=ideal), "/damping/0", '"motor"')
        for damping in ({"kind": "eddy_current_brake", "damping": 1e-5}, self.HELD,
                        {"kind": "torque_sensed_damper", "damping": 1e-5, "cutoff": "5 Hz"},
                        {"kind": "high_pass_damper", "damping": 1e-5, "inertia": 1e-6}):
            name = self.write_model(self.model(damping, motor=None, amplifier=ideal))
            for command in MODEL_COMMANDS:
                answer = self.run_program(command, name, *QUICK[command])
                with self.subTest(command=command, damping=damping["kind"]):
                    self.assertIn(answer.code, (0, 1), answer)

    def test_feedback_that_takes_all_of_a_steady_command_is_refused_with_its_share(self):
        # d (R_m - R)/K_t^2 = 6e-4 * 0.96/23.5e-3^2
        feedback = {"kind": "back_emf", "damping": 6e-4, "resistance_estimate": "1.1 ohm"}
        self.assert_all_commands_refuse(self.model(feedback, amplifier={"kind": "current"}), "/damping: ",
                                        "takes 1.043 of every steady effort", "below 1", "estimate")

    def test_values_that_cannot_be_are_refused_with_the_bound(self):
        for damping, key, bound in (({"kind": "back_emf", "damping": -1e-6}, "damping", "at least 0 N.m.s/rad"),
                                    ({"kind": "eddy_current_brake", "damping": 0}, "damping", "above 0 N.m.s/rad"),
                                    ({"kind": "torque_sensed_damper", "damping": 1e-6, "cutoff": 0}, "cutoff",
                                     "above 0 Hz"),
                                    ({"kind": "held_impedance", "bandwidth": "-1 Hz"}, "bandwidth", "above 0 Hz")):
            self.assert_all_commands_refuse(self.model(damping, amplifier={"kind": "current"}), f"/damping/0/{key}",
                                            bound)


class NumericalFailureTest(ProgramTest):

    def test_an_unstable_bare_device_is_refused_with_element_pole_and_remedy(self):
        name = self.write_model(oscillating_device())
        for command in MODEL_COMMANDS:
            answer = self.run_program(command, name)
            with self.subTest(command=command):
                self.assert_refused(answer, "damping.0", "unstable", "pole at +", "rad/s",
                                    "doubles every", "bandwidth", code=3)

    def test_an_integrator_that_gives_up_says_when(self):
        for engine in ("cvode", "odeint"):
            answer = self.run_program("simulate", RC_DISPLAY, "--engine", engine, "--max-steps", "1",
                                      "--csv", "trace.csv", "-o", "result.json")
            with self.subTest(engine=engine):
                self.assert_refused(answer, engine, "gave up", "--max-steps", code=3)
                self.assertRegex(answer.err, r"t = [0-9.e+-]+ s")
        self.assertEqual(self.files(), ["result.json", "trace.csv"])  # the run up to there (files_test)

    def test_a_singular_network_is_refused_with_the_element(self):
        name = self.write_model(with_value(load_example(), "/damping/0/capacitance", 1e307))
        answer = self.run_program("impedance", name, "--frequency", "10kHz")
        self.assert_refused(answer, "singular", code=3)
        self.assert_refused(answer, "damping.0", code=3)

    def test_a_loop_that_diverges_is_an_answer_and_no_error(self):
        model = with_value(load_example(), "/controller/stiffness", 4)
        name = self.write_model(model)
        answer = self.run_program("simulate", name, "--duration", "5 s", "--csv", "trace.csv", "--json")
        self.assertEqual((answer.code, answer.err), (0, ""), answer)
        self.assertEqual(answer.json["classification"], "diverges")
        self.assertIn("trace.csv", self.files())

    def test_a_run_whose_numbers_overflow_is_never_said_to_settle(self):
        name = self.write_model(with_value(load_example(), "/simulation/initial_velocity", 1e200))
        answer = self.run_program("simulate", name, "--json")
        if answer.code == 0:
            self.assertNotEqual(answer.json["classification"], "settles")
            self.assertNotIn(None, answer.json["energy"].values(), "a ledger with holes passes for an answer")
        else:
            self.assertIn(answer.code, (2, 3), answer)
            self.assert_refused(answer, "finite", code=answer.code)

    def test_an_inductance_too_small_for_the_exact_engine_is_computed_rightly_or_refused(self):
        # 1e-16 H: a pole at 1e17 rad/s. With the winding left out the answer is known.
        base = load_example()
        expected = self.ask("simulate", self.write_model(with_value(base, "/motor/inductance", 0)))
        answer = self.run_program("simulate", self.write_model(with_value(base, "/motor/inductance", 1e-16)),
                                  "--json")
        if answer.code == 3:
            return self.assert_refused(answer, "inductance", code=3)
        self.assertEqual(answer.code, 0, answer)
        self.assertAlmostEqual(answer.json["trace"]["position"][-1] / expected["trace"]["position"][-1], 1,
                               delta=1e-3)


class TextTest(ProgramTest):

    def test_a_models_name_cannot_send_commands_to_the_terminal(self):
        name = self.write_model(with_value(load_example(), "/name", "red\x1b[31m device\x07"))
        for command in MODEL_COMMANDS:
            answer = self.run_program(command, name, *QUICK[command])
            with self.subTest(command=command):
                self.assertIn("device", answer.out)
                self.assertNotIn("\x1b", answer.out)
                self.assertNotIn("\x07", answer.out)

    def test_a_models_name_cannot_run_commands_through_the_plot(self):
        name = self.write_model(with_value(load_example(), "/name",
                                           "`touch owned` \"; system('touch owned'); \"\n!touch owned\n"))
        answer = self.run_program("impedance", name, "--points", "5", "--svg", "z.svg", "--quiet")
        self.assertEqual(answer.code, 0, answer)
        self.assertEqual(self.files(), ["model.json", "z.svg"])


if __name__ == "__main__":
    unittest.main()
