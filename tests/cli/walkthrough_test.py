"""The README's walk through the bench, command by command as it stands there, on a free port."""
import json
import re
import shlex
import subprocess
import unittest

from program import EXAMPLES, ROOT, DeviceTest, program
from twin_test import Twin


def commands():
    section = (ROOT / "README.md").read_text(encoding="utf-8").split("## On the bench\n", 1)[1].split("\n## ", 1)[0]
    return [line.strip() for line in section.splitlines() if line.startswith("    gyrator ")]


class WalkthroughTest(DeviceTest):

    def test_every_command_does_what_the_readme_says(self):
        lines = commands()
        self.assertTrue(lines[0].startswith("gyrator twin ") and lines[0].endswith(" &"))
        (self.folder / "examples").symlink_to(EXAMPLES)
        model, *options = shlex.split(lines[0].removesuffix(" &"))[2:]
        twin = Twin(*options, "--listen", "127.0.0.1:0", model=model, folder=self.folder)
        self.addCleanup(twin.__exit__)
        answers = {}
        for line in lines[1:]:
            words = shlex.split(line.replace("tcp://127.0.0.1:1502", twin.where[0]))
            answer = self.run_program(*words[1:], timeout=60)
            with self.subTest(line=line):
                self.assertEqual(answer.code, 1 if words[1] == "diff" else 0, answer)
            answers[words[1]] = answer
        self.assertEqual(list(answers), ["backup", "identify", "tune", "diff", "report", "restore"])
        # What the README says of it.
        motor = json.loads((self.folder / "motor.json").read_text())
        for path, truth in [("motor/resistance", 1.31), ("motor/torque_constant", 0.041),
                            ("mechanics/inertia", 7.4e-6)]:
            group, name = path.split("/")
            nominal, low, high = map(float, re.findall(r"([\d.e-]+) \S+", motor[group][name].replace("(", "")
                                                       .replace(" to ", " ").replace(")", ""))[:3])
            self.assertLess(low, truth)
            self.assertLess(truth, high)
            self.assertAlmostEqual(nominal / truth, 1, delta=0.02)
        tuned = json.loads((self.folder / "tuned.json").read_text())
        self.assertEqual((tuned["outcome"], tuned["verdict"]), ("reached", "passive"))
        self.assertEqual(tuned["settings"], {"damping_resistance": 7, "damping_capacitance": 70e-6})
        self.assertAlmostEqual(tuned["measured_max_stiffness"], 0.122, delta=0.001)
        self.assertIn("the wall of 0.1 N·m/rad is passive", answers["tune"].out)
        self.assertIn("read back", answers["restore"].out)
        self.assertIn("Tuning of the amplifier", (self.folder / "bench.html").read_text())
        for name in ("motor.svg", "tuned.svg"):
            self.assertIn("<svg", (self.folder / name).read_text())
        url = ["--connect", twin.where[0], "--profile", "gyrator_twin"]
        self.assertEqual(self.run_program("diff", "before.json", *url).code, 0)


if __name__ == "__main__":
    unittest.main()
