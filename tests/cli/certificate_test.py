"""Certificates: what passivity --certificate writes verifies, and nothing that was changed in it does."""
import copy
import json
import math
import subprocess
import sys
import unittest

from program import EXAMPLES, ROOT, ProgramTest, load_example, with_value

CHECK_BY_HAND = ROOT / "docs/check_certificate.py"

# Small ones whose every field is tampered with.
PASSIVE = EXAMPLES / "rc_display_ideal_path.json"
NOT_PASSIVE = EXAMPLES / "rc_display.json"

# Counts that carry no claim, and texts whose sense cannot be computed again: known by the digest alone.
BY_DIGEST_ALONE = ("direct_aliases", "bounded_aliases", "program", "explanation")
# A larger bound on what lies between the points claims less, and is as true as the smaller one.
WEAKER_CLAIM = "curvature"


def leaves(value, path=()):
    if isinstance(value, dict):
        for key in value:
            yield from leaves(value[key], path + (key,))
    elif isinstance(value, list):
        for i, item in enumerate(value):
            yield from leaves(item, path + (i,))
    else:
        yield path


def at(document, path):
    for key in path:
        document = document[key]
    return document


def with_leaf(document, path, value):
    changed = copy.deepcopy(document)
    at(changed, path[:-1])[path[-1]] = value
    return changed


class CertificateTest(ProgramTest):

    def certify(self, model, name="certificate.json"):
        answer = self.run_program("passivity", model, "--certificate", name)
        self.assertIn(answer.code, (0, 1), answer)
        return json.loads((self.folder / name).read_text())

    def verify(self, certificate, name="changed.json"):
        (self.folder / name).write_text(json.dumps(certificate))
        return self.run_program("verify-certificate", name)

    def sign(self, certificate):
        """The certificate with the digest that its content has; the program tells which."""
        answer = self.verify(certificate, "unsigned.json")
        for line in answer.out.splitlines():
            if line.startswith("  digest: recorded"):
                return {**certificate, "digest": line.rsplit("found ", 1)[1]}
        return certificate


class EveryExampleTest(CertificateTest):

    def test_every_example_that_can_be_judged_has_a_certificate_that_verifies(self):
        seen = {"passive": 0, "not_passive": 0}
        models = [m for m in sorted(EXAMPLES.glob("**/*.json"))
                  if "motion" in json.loads(m.read_text()) or "motor" in json.loads(m.read_text())]
        for model in models:
            answer = self.run_program("passivity", model, "--certificate", "certificate.json")
            if answer.code not in (0, 1):
                self.assertNotIn("certificate", answer.err)
                continue
            checked = self.ask("verify-certificate", "certificate.json")
            with self.subTest(model=str(model.relative_to(EXAMPLES))):
                self.assertEqual(checked["discrepancies"], [])
                self.assertTrue(checked["verified"])
                self.assertLess(checked["seconds"], 5)
                seen[checked["verdict"]] += 1
                for loop in checked["loops"]:
                    self.assertGreater(loop["smallest_margin"], 0)
                    self.assertGreater(loop["smallest_margin"], 0.5 * loop["recorded_lowest_margin"])
                by_hand = subprocess.run([sys.executable, CHECK_BY_HAND, self.folder / "certificate.json", "6"],
                                         capture_output=True, text=True, timeout=60)
                self.assertEqual((by_hand.returncode, by_hand.stderr), (0, ""), by_hand.stdout)
                self.assertIn("VERIFIED", by_hand.stdout)
        self.assertGreater(seen["passive"], 5)
        self.assertGreater(seen["not_passive"], 5)

    def test_delays_sensor_places_and_wider_loops_verify(self):
        model = json.loads(PASSIVE.read_text())
        for change in ({"/sampling/delay": "300 us"}, {"/sampling/delay": "1 ms"}):
            changed = model
            for path, value in change.items():
                changed = with_value(changed, path, value)
            certificate = self.certify(self.write_model(changed))
            answer = self.verify(certificate)
            with self.subTest(change=change):
                self.assertEqual(answer.code, 0, answer)


class TamperingTest(CertificateTest):

    def assert_caught(self, certificate, what):
        answer = self.verify(certificate)
        with self.subTest(what=what):
            self.assertNotEqual(answer.code, 0, answer)
            self.assertIn(answer.code, (1, 2), answer)
            if answer.code == 1:
                self.assertIn("NOT VERIFIED", answer.out)
            for jargon in ("internal error", "json.exception", "std::"):
                self.assertNotIn(jargon, answer.err)

    def tampered(self, certificate, path):
        """Every value a little off: a number by 2 % of the largest beside it, a text by one letter."""
        value = at(certificate, path)
        if isinstance(value, bool):
            return not value
        if isinstance(value, (int, float)):
            beside = at(certificate, path[:-1])
            size = max([abs(v) for v in (beside.values() if isinstance(beside, dict) else beside)
                        if isinstance(v, (int, float))] + [abs(value)])
            if "intervals" in path:  # a number's own size, or its partner's where it is the small part of two
                size = self.size_in_interval(certificate, path)
            return value + 1 if isinstance(value, int) else value + 0.02 * (size or 1)
        return (value or "") + "x"

    @staticmethod
    def size_in_interval(certificate, path):
        *_, column, index = path
        interval = {name: values[index] for name, values in at(certificate, path[:-2]).items()}
        if column in ("law_real", "law_imag"):
            return math.hypot(interval["law_real"], interval["law_imag"])
        if column in ("center_real", "center_imag"):
            return math.hypot(interval["center_real"], interval["center_imag"])
        if column == "slope":
            return max(abs(interval["slope"]), interval["margin"] / interval["reach"])
        return abs(interval[column])

    def few_intervals(self, path):
        """Every tenth interval of a certificate stands for all."""
        return "intervals" not in path or path[-1] % 10 == 0

    def check_every_leaf(self, model, resigned):
        certificate = self.certify(model)
        self.assertEqual(self.verify(certificate).code, 0)
        paths = [p for p in leaves(certificate) if p[0] != "model" and self.few_intervals(p)]
        self.assertGreater(len(paths), 20)
        for path in paths:
            if resigned and (path[-1] in BY_DIGEST_ALONE or path == ("digest",) or WEAKER_CLAIM in path):
                continue
            changed = with_leaf(certificate, path, self.tampered(certificate, path))
            self.assert_caught(self.sign(changed) if resigned else changed, path)

    def test_no_leaf_of_a_passive_certificate_can_be_changed(self):
        self.check_every_leaf(PASSIVE, resigned=False)

    def test_no_number_of_a_passive_certificate_can_be_changed_and_signed_again(self):
        self.check_every_leaf(PASSIVE, resigned=True)

    def test_no_leaf_of_a_refutation_can_be_changed(self):
        self.check_every_leaf(NOT_PASSIVE, resigned=False)

    def test_no_number_of_a_refutation_can_be_changed_and_signed_again(self):
        self.check_every_leaf(NOT_PASSIVE, resigned=True)

    def test_a_law_with_a_resonance_between_the_sampled_frequencies_is_not_the_models(self):
        certificate = self.certify(PASSIVE)
        period = 1e-3
        nyquist = math.pi / period
        sampled = [nyquist * (i + 2) / 48 if i % 2 == 0 else nyquist * 10**(-4 * i / 48) for i in range(48)]
        loop = certificate["loops"][0]
        omega = max(loop["intervals"]["omega"], key=lambda w: min(abs(w - s) for s in sampled))
        # c/(z - p) and its conjugate, |p| a billionth below one: at the middle of an interval a thousandth of H,
        # at the frequencies of the other comparison less than they tell.
        radius, angle = 1 - 1e-9, omega * period
        law = loop["law"]
        states = len(law["A"])
        law["A"] = [row + [0, 0] for row in law["A"]]
        law["A"] += [[0] * states + [2 * radius * math.cos(angle), -radius**2], [0] * states + [1, 0]]
        law["B"] += [[1], [0]] if law["B"] and isinstance(law["B"][0], list) else [1, 0]
        size = 1e-3 * math.hypot(loop["intervals"]["law_real"][0], loop["intervals"]["law_imag"][0])
        more = [size * 1e-9 * 2 * math.sin(angle), 0]
        law["C"] = [law["C"][0] + more] if isinstance(law["C"][0], list) else law["C"] + more
        answer = self.verify(self.sign(certificate))
        self.assertEqual(answer.code, 1, answer)
        self.assertIn(f"loops/0/law: H at {omega:.6g} rad/s is off", answer.out)

    def test_the_schema_says_what_it_must_be(self):
        certificate = {**self.certify(PASSIVE), "schema": "gyrator/certificate/2"}
        self.assertIn("schema: recorded gyrator/certificate/2: must be gyrator/certificate/1",
                      self.verify(certificate).out)

    def test_margins_have_the_models_unit(self):
        answer = self.verify(self.certify(PASSIVE))
        self.assertRegex(answer.out, r"margin at least \S+ N\.m\.s/rad between")
        self.assertRegex(answer.out, r"claims \S+ N\.m\.s/rad\)")

    def test_a_curvature_that_claims_more_than_is_true_is_caught(self):
        certificate = self.certify(PASSIVE)
        intervals = certificate["loops"][0]["intervals"]
        i = max(range(len(intervals["reach"])),
                key=lambda k: intervals["curvature"][k] * intervals["reach"][k]**2 / intervals["margin"][k])
        changed = copy.deepcopy(certificate)
        values = changed["loops"][0]["intervals"]
        values["curvature"][i] = 1.02 * 2 * intervals["margin"][i] / intervals["reach"][i]**2  # leaves no margin
        self.assert_caught(self.sign(changed), "no margin")

    def test_intervals_can_be_neither_removed_nor_swapped(self):
        certificate = self.certify(PASSIVE)
        count = len(certificate["loops"][0]["intervals"]["omega"])
        for index in (0, count // 2, count - 1):
            changed = copy.deepcopy(certificate)
            for values in changed["loops"][0]["intervals"].values():
                del values[index]
            self.assert_caught(self.sign(changed), f"removed {index}")
            changed = copy.deepcopy(certificate)
            other = index - 1 if index else 1
            for values in changed["loops"][0]["intervals"].values():
                values[index], values[other] = values[other], values[index]
            self.assert_caught(self.sign(changed), f"swapped {index}")
        changed = copy.deepcopy(certificate)
        changed["loops"][0]["intervals"]["radius"].append(1.0)
        self.assert_caught(self.sign(changed), "one radius too many")
        changed = copy.deepcopy(certificate)
        for values in changed["loops"][0]["intervals"].values():
            values.clear()
        self.assert_caught(self.sign(changed), "no intervals")
        self.assert_caught(self.sign({**certificate, "loops": []}), "no loops")

    def test_another_model_verdict_period_or_delay_is_not_certified(self):
        for model in (PASSIVE, NOT_PASSIVE):
            certificate = self.certify(model)
            source = certificate["model"]
            stiffer = copy.deepcopy(certificate)
            stiffer["model"]["controller"]["stiffness"] = "0.123 N.m/rad"
            self.assert_caught(self.sign(stiffer), "stiffness")
            heavier = copy.deepcopy(certificate)
            heavier["model"]["mechanics"]["damping"] = "1.01 uN.m.s/rad"
            self.assert_caught(self.sign(heavier), "damping")
            renamed = with_leaf(certificate, ("model", "name"), source["name"] + "x")
            self.assert_caught(self.sign(renamed), "name")
            other = {"passive": "not_passive", "not_passive": "passive"}[certificate["verdict"]]
            self.assert_caught(self.sign({**certificate, "verdict": other}), "verdict")
            self.assert_caught(self.sign({**certificate, "period_s": "1/999"}), "period")
            self.assert_caught(self.sign({**certificate, "delay_s": "1/10000"}), "delay")
            for key in certificate:
                self.assert_caught(self.sign({k: v for k, v in certificate.items() if k != key}), f"without {key}")
            self.assert_caught(self.sign({**certificate, "note": "trust me"}), "another field")

    def test_an_operator_that_supplies_energy_refutes_nothing(self):
        certificate = self.certify(NOT_PASSIVE)
        refutation = certificate["loops"][0]["refutation"]
        self.assertEqual(refutation["kind"], "operator")
        changed = copy.deepcopy(certificate)
        changed["loops"][0]["refutation"]["damping"] = -1e-3
        answer = self.verify(self.sign(changed))
        self.assertEqual(answer.code, 1, answer)
        self.assertIn("a passive operator has none", answer.out)


class UseTest(CertificateTest):

    def test_what_was_checked_is_told(self):
        self.certify(PASSIVE)
        answer = self.run_program("verify-certificate", "certificate.json")
        self.assertEqual(answer.code, 0, answer)
        for said in ("VERIFIED", "PASSIVE", "intervals cover", "margin at least", "checked in"):
            self.assertIn(said, answer.out)

    def test_what_is_no_certificate_is_refused(self):
        self.assert_refused(self.run_program("verify-certificate", "nothing.json"), "nothing.json")
        self.write_model("[]")
        self.assert_refused(self.run_program("verify-certificate", "model.json"), "is not a certificate")
        self.write_model(load_example())
        self.assert_refused(self.run_program("verify-certificate", "model.json"), "is not a certificate")

    def test_the_check_by_hand_sees_what_is_wrong(self):
        certificate = self.certify(PASSIVE)
        for column in ("radius", "margin", "center_real", "omega"):
            changed = copy.deepcopy(certificate)
            values = changed["loops"][0]["intervals"][column]
            values[0] *= 0.97
            (self.folder / "changed.json").write_text(json.dumps(changed))
            done = subprocess.run([sys.executable, CHECK_BY_HAND, self.folder / "changed.json", "3"],
                                  capture_output=True, text=True, timeout=60)
            with self.subTest(column=column):
                self.assertEqual(done.returncode, 1)
                self.assertIn("NOT VERIFIED", done.stderr)


if __name__ == "__main__":
    unittest.main()
