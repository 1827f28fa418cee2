"""Every shipped example passes every command; what is shipped beside them fits the program."""
import json
import re
import subprocess
import unittest

from program import EXAMPLES, MODEL_COMMANDS, RC_DISPLAY, ROOT, ProgramTest, example_models, program

# What would make a page fetch something: attributes and rules with an address that is not "#…" or data. The page's
# one script and the figures' data stand inside it.
FETCHES = re.compile(r"""(?:\s(?:src|srcset|href|xlink:href|action|data|poster)\s*=\s*["']?(?!["']?(?:\#|data:))
                         |url\(\s*["']?(?!["']?(?:\#|data:))|@import|<link\b|<script\b(?!>|\stype="application/json")|<iframe\b|<object\b|<base\b)
                         [^>\s]*""", re.IGNORECASE | re.VERBOSE)


class EveryExampleTest(ProgramTest):

    def test_every_command_takes_every_example(self):
        self.assertGreaterEqual(len(example_models()), 7)
        for model in example_models():
            for command in MODEL_COMMANDS:
                answer = self.run_program(command, model)
                with self.subTest(model=model.name, command=command):
                    self.assertIn(answer.code, (0, 1) if command == "passivity" else (0,), answer)
                    self.assertEqual(answer.err, "")
                    self.assertIn(json.loads(model.read_text())["name"], answer.out)
                    self.assertNotRegex(answer.out, r"\bnan\b|\binf\b|-0 s")

    def test_every_plot_is_drawn_of_every_command(self):
        for command in MODEL_COMMANDS:
            png = ["--png", "plot.png"] if command == "zwidth" else []  # the others' help shows it, below
            answer = self.run_program(command, RC_DISPLAY, "--quiet", "--svg", "plot.svg", *png)
            with self.subTest(command=command):
                self.assertIn(answer.code, (0, 1), answer)
                svg = (self.folder / "plot.svg").read_text()
                self.assertIn("<svg", svg)
                self.assertTrue(svg.rstrip().endswith("</svg>"))
                self.assertGreater(svg.count("<path"), 4)

        png = (self.folder / "plot.png").read_bytes()
        self.assertTrue(png.startswith(b"\x89PNG\r\n\x1a\n") and png.endswith(b"IEND\xaeB`\x82"))

    def test_every_example_makes_a_report_that_stands_alone(self):
        for model in example_models():
            # All results of one rotary and the linear device; drawing takes its time.
            commands = MODEL_COMMANDS if model.stem in ("rc_display", "p3_plant") else ("passivity",)
            for command in commands:
                more = ["--simulate-counterexample"] if command == "passivity" else []
                self.run_program(command, model, *more, "-o", f"{command}.json", "--quiet")
            answer = self.run_program("report", *[f"{c}.json" for c in commands], "-o", "report.html")
            with self.subTest(model=model.name):
                self.assertEqual((answer.code, answer.err), (0, ""), answer)
                page = (self.folder / "report.html").read_text()
                self.assertTrue(page.startswith("<!DOCTYPE html>"))
                self.assertTrue(page.rstrip().endswith("</html>"))
                self.assertEqual(FETCHES.findall(page), [])
                self.assertEqual(page.count("<script>"), 1)
                self.assertIn("default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-", page)
                self.assertGreaterEqual(page.count("<svg"), len(commands))
                for command in commands:  # how each result was made
                    self.assertIn(f"gyrator {command} ", page)
                addresses = set(re.findall(r"https?://[^\s\"'<>)]+", page))
                self.assertLessEqual(addresses, {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"})

    def test_the_fetch_pattern_finds_what_a_page_must_not_have(self):
        for bad in ('<img src="x.png">', "<a href='http://x'>", "background: url(x.png)", '<script src="x.js">', "@import 'x'",
                    '<image xlink:href="x.png"/>'):
            self.assertRegex(f" {bad}", FETCHES)
        for good in ('<use xlink:href="#p"/>', "fill: url(#g)", '<image href="data:image/png;base64,AA"/>'):
            self.assertNotRegex(f" {good}", FETCHES)

    def test_the_help_texts_examples_run(self):
        (self.folder / "examples").symlink_to(EXAMPLES)
        (self.folder / "model.json").write_bytes(RC_DISPLAY.read_bytes())
        for command in MODEL_COMMANDS + ("tolerance", "report", "schematic", "schema", "verify-certificate"):
            help_text = self.run_program(command, "--help").out
            line = help_text.split("Example:\n", 1)[1].splitlines()[0].strip()
            self.assertTrue(line.startswith("gyrator "), line)
            done = subprocess.run(["sh", "-c", line.replace("gyrator ", f"'{program()}' ")], cwd=self.folder,
                                  capture_output=True, text=True, timeout=20)
            with self.subTest(line=line):
                self.assertIn(done.returncode, (0, 1), done.stderr)
                self.assertEqual(done.stderr, "")


class ShippedTest(ProgramTest):

    def test_the_first_run_script_leaves_report_plots_and_numbers(self):
        out = self.folder / "with space"
        done = subprocess.run([EXAMPLES / "first-run", program(), out], cwd=self.folder, capture_output=True,
                              text=True, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for name in ("report.html", "zwidth.png", "finding.png", "passivity.json", "zwidth.json", "impedance.json",
                     "simulate.json", "passivity.csv", "zwidth.csv", "impedance.csv", "simulate.csv"):
            self.assertGreater((out / name).stat().st_size, 100, name)
        self.assertIn("NOT PASSIVE", done.stdout)
        for path in re.findall(r":\s+(/.*\.(?:html|png))$", done.stdout, re.MULTILINE):
            self.assertTrue((self.folder / path).exists(), path)
        self.assertIn("7.6 times", (out / "report.html").read_text())

    def test_the_shipped_schema_is_the_programs(self):
        self.assertEqual(self.run_program("schema").out, (ROOT / "schemas/model.schema.json").read_text())

    def test_the_schema_knows_every_key_of_every_example(self):
        known = set(re.findall(r'"(\w+)": \{', self.run_program("schema").out))
        for model in example_models():
            for key in re.findall(r'"(\w+)":', model.read_text()):
                self.assertIn(key, known, model.name)

    def test_the_manual_names_every_key_of_every_example(self):
        manual = self.run_program("schema", "--manual").out
        for model in example_models():
            for key in set(re.findall(r'"(\w+)":', model.read_text())) - {"kind", "motion"}:
                self.assertIn(f"| `{key}` |", manual, model.name)


if __name__ == "__main__":
    unittest.main()
