"""The pages on dampings: each has a model that runs, and says what the program says."""
import json
import math
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
        """Every page has its largest stiffness in bold, at B = 0 unless its command lists more, or **no limit**."""
        for page in pages():
            text = page.read_text().split("## On the RE25")[1]
            printed = re.search(r"\*\*(no limit|[\d., ]+)( N·m/rad)?\*\*", text)[1]
            damping = re.search(r"zwidth .*--damping (\S+)", text)
            model = DRIVES / "models" / f"{page.stem}.json"
            if damping:
                zwidth = self.ask("zwidth", model, "--damping", damping[1], "--criterion", "exact_disk")
                found, holds = zwidth["max_stiffness"], all(zwidth["feasible"])
            else:
                criteria = self.ask("passivity", model, "--no-counterexample")["criteria"]
                disk = next(c for c in criteria if c["name"] == "exact_disk")
                found, holds = [disk["max_stiffness"]], disk["applies"] and disk["holds"]
            with self.subTest(page=page.name, printed=printed, found=found):
                self.assertTrue(holds)
                if printed == "no limit":
                    self.assertEqual(found, [None] * len(found))
                    continue
                self.assertNotIn(None, found)
                printed = [float(x) for x in printed.split(", ")]
                self.assertEqual(len(printed), len(found))
                for p, f in zip(printed, found):
                    self.assertAlmostEqual(p / f, 1, delta=0.006)  # two or three printed digits

    def run_model(self, kind, **changes):
        model = json.loads((DRIVES / "models" / f"{kind}.json").read_text())
        model["simulation"].update(changes.pop("simulation", {}))
        model.update(changes)
        return self.ask("simulate", self.write_model(model))

    def velocity_at(self, result, time):
        """Interpolated between the sample instants."""
        t, v = result["trace"]["time_s"], result["trace"]["velocity"]
        k = next(k for k, later in enumerate(t) if later > time)
        return v[k - 1] + (v[k] - v[k - 1]) * (time - t[k - 1]) / (t[k] - t[k - 1])

    def test_the_walls_of_the_brake_settle_and_diverge_as_its_page_says(self):
        for speed, outcome in ((10, "settles"), (14, "settles"), (16, "diverges")):
            run = self.run_model("friction_brake", simulation={"duration": "1 s", "initial_velocity": speed})
            self.assertEqual(run["classification"], outcome, speed)

    def test_the_brake_takes_the_device_down_in_a_straight_line_and_then_as_a_damper(self):
        run = self.run_model("friction_brake", controller={"kind": "none"})
        effort, inertia, own, imitated, start = 5e-3, 1.07e-6, 1.2e-6, 1e-3, 100
        # J dv/dt = -b_m v - f_c
        for time in (5e-3, 10e-3, 20e-3):
            fall = (start + effort / own) * math.exp(-own * time / inertia) - effort / own
            self.assertAlmostEqual(self.velocity_at(run, time), fall, delta=2e-5)  # 1e-9 of 100 rad/s in each of 200 steps
        ratio = self.velocity_at(run, 23e-3) / self.velocity_at(run, 22e-3)
        self.assertAlmostEqual(ratio, math.exp(-1e-3 * (own + imitated) / inertia), delta=1e-6)

    def test_the_clamp_takes_the_device_down_to_the_velocity_that_its_page_names(self):
        run = self.run_model("clamp", controller={"kind": "none"})
        for time, velocity in ((2e-3, 408), (5e-3, 328), (10e-3, 276)):
            self.assertAlmostEqual(self.velocity_at(run, time), velocity, delta=0.6)  # printed digits
        inertia, own, slope, bend = 1.07e-6, 1.2e-6, 23.5e-3**2 / 2.16, 6 / 23.5e-3
        rest = bend * slope / (slope + own)  # J dv/dt = -b_m v - (clamp-2)
        for time in (5e-3, 10e-3):
            fall = rest + (500 - rest) * math.exp(-(slope + own) * time / inertia)
            # L_m/(R_m + r) = 0.11 ms delays the braking by as much: 0.5 % of the fall at 4 time constants or less
            self.assertAlmostEqual(self.velocity_at(run, time) / fall, 1, delta=0.005)


if __name__ == "__main__":
    unittest.main()
