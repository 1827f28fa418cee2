"""The pages on dampings: each has a model that runs, and says what the program says."""
import json
import re
import shlex
import unittest

from program import MODEL_COMMANDS, ROOT, ProgramTest, program

DRIVES = ROOT / "docs/drives"
QUICK = {"impedance": ["--points", "9"], "zwidth": ["--points", "5"], "passivity": ["--no-counterexample"],
         "simulate": []}


def pages():
    found = sorted(page for page in DRIVES.glob("*.md") if page.stem != "README")
    assert found, f"no pages in {DRIVES}"
    return found


class DrivePagesTest(ProgramTest):

    def test_every_page_shows_its_model_as_it_is_and_every_model_has_a_page(self):
        self.assertEqual([page.stem for page in pages()], sorted(m.stem for m in (DRIVES / "models").glob("*.json")))
        for page in pages():
            with self.subTest(page=page.name):
                text = page.read_text()
                model = (DRIVES / "models" / f"{page.stem}.json").read_text()
                self.assertIn(f"```json\n{model.rstrip()}\n```", text)
                self.assertIn(page.stem, [d["kind"] for d in json.loads(model)["damping"]])
                self.assertIn(f"![schematic](../images/schematics/{page.stem}.svg)", text)
                self.assertIn(f"]({page.name})", (DRIVES / "README.md").read_text())

    def test_every_model_runs_through_every_command_and_its_wall_is_passive(self):
        for page in pages():
            model = DRIVES / "models" / f"{page.stem}.json"
            for command in MODEL_COMMANDS:
                answer = self.run_program(command, model, *QUICK[command])
                with self.subTest(model=model.name, command=command):
                    self.assertEqual((answer.code, answer.err), (0, ""), answer)
                    self.assertIn(json.loads(model.read_text())["name"], answer.out)

    def test_the_commands_of_the_pages_run(self):
        (self.folder / "docs").symlink_to(ROOT / "docs")
        for page in pages():
            lines = re.findall(r"^    gyrator (.*)$", page.read_text(), re.MULTILINE)
            self.assertTrue(lines, page.name)
            for line in lines:
                with self.subTest(line=line):
                    self.assertIn(self.run_program(*shlex.split(line)).code, (0, 1))

    def test_the_limits_printed_in_bold_are_the_programs(self):
        """Every page has its largest stiffness in bold, at B = 0 unless its command lists more."""
        for page in pages():
            text = page.read_text().split("## On the RE25")[1]
            printed = [float(x) for x in re.search(r"\*\*([\d., ]+)( N·m/rad)?\*\*", text)[1].split(", ")]
            damping = re.search(r"zwidth .*--damping (\S+)", text)
            model = DRIVES / "models" / f"{page.stem}.json"
            if damping:
                found = self.ask("zwidth", model, "--damping", damping[1], "--criterion", "exact_disk")["max_stiffness"]
            else:
                criteria = self.ask("passivity", model, "--no-counterexample")["criteria"]
                found = [next(c for c in criteria if c["name"] == "exact_disk")["max_stiffness"]]
            with self.subTest(page=page.name, printed=printed, found=found):
                self.assertEqual(len(printed), len(found))
                for p, f in zip(printed, found):
                    self.assertAlmostEqual(p / f, 1, delta=0.006)  # two or three printed digits


if __name__ == "__main__":
    unittest.main()
