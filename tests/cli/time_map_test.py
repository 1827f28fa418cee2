"""Z-width maps by co-simulation, as a user asks for them."""
import json, os, pathlib, subprocess, tempfile, unittest

GYRATOR = os.environ["GYRATOR"]
EXAMPLE = str(pathlib.Path(__file__).resolve().parents[2] / "examples" / "rc_display.json")


def run(*arguments):
    return subprocess.run([GYRATOR, *arguments], capture_output=True, text=True, check=False)


class TimeMap(unittest.TestCase):
    def test_a_map_has_a_class_for_every_cell_and_a_boundary(self):
        done = run("zwidth", EXAMPLE, "--criterion", "time,coupled", "--from", "0", "--to", "6e-4", "--points", "9",
                   "--rows", "32", "--duration", "2 s", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        coupled, time = json.loads(done.stdout)["boundaries"]
        cells = time["map"]
        self.assertEqual(cells["samples"], 2000)
        self.assertEqual([len(row) for row in cells["outcome"]], [9] * 32)
        height = cells["stiffness"][1] - cells["stiffness"][0]
        for found, exact in zip(time["max_stiffness"], coupled["max_stiffness"]):
            self.assertAlmostEqual(found, exact, delta=height)
        for row, K in zip(cells["outcome"], cells["stiffness"]):
            for outcome, limit in zip(row, time["max_stiffness"]):
                if K < limit:
                    self.assertEqual(outcome, 0)

    def test_a_map_is_drawn(self):
        with tempfile.TemporaryDirectory() as folder:
            picture = pathlib.Path(folder) / "map.svg"
            done = run("zwidth", EXAMPLE, "--criterion", "time", "--points", "5", "--rows", "5", "--svg", str(picture))
            self.assertEqual(done.returncode, 0, done.stderr)
            text = picture.read_text()
            for name in ("settles", "diverges"):
                self.assertIn(name, text)

    def test_columns_of_all_criteria_stand_at_the_same_dampings(self):
        with tempfile.TemporaryDirectory() as folder:
            table = pathlib.Path(folder) / "map.csv"
            dampings = ",".join(f"{(i * 37) % 90 * 6e-6:.9g}" for i in range(90))  # 90 of them, out of order
            done = run("zwidth", EXAMPLE, "--criterion", "coupled,time", "--damping", dampings, "--stiffness", "0..1.5",
                       "--rows", "30", "--duration", "2 s", "--csv", str(table), "--json")
            self.assertEqual(done.returncode, 0, done.stderr)
            coupled, time = json.loads(done.stdout)["boundaries"]
            self.assertEqual(coupled["damping"], time["damping"])
            self.assertEqual(coupled["damping"], sorted(coupled["damping"]))
            rows = table.read_text().splitlines()
            self.assertEqual(len(rows), 91)
            for row in rows[1:]:
                _, stable, settles = map(float, row.split(","))
                self.assertAlmostEqual(stable, settles, delta=0.05)  # a row of the map

    def test_the_hand_can_hit_and_hold(self):
        done = run("zwidth", EXAMPLE, "--criterion", "time", "--damping", "1e-4", "--stiffness", "0.05,1.5", "--gesture",
                   "hit,hold", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        cells = json.loads(done.stdout)["boundaries"][0]["map"]
        self.assertEqual([g["kind"] for g in cells["gestures"]], ["hit", "hold"])
        self.assertEqual(cells["outcome"], [[0], [2]])

    def test_what_only_the_map_has_is_refused_without_it(self):
        for option in ("--rows=9", "--stiffness=0..1", "--gesture=hit", "--duration=1s", "--threads=1"):
            done = run("zwidth", EXAMPLE, "--criterion", "coupled", "--points", "2", option)
            self.assertEqual(done.returncode, 2, option)
            self.assertIn("--criterion time", done.stderr)
        done = run("zwidth", EXAMPLE, "--envelope", "--rows", "9")
        self.assertEqual(done.returncode, 2)

    def test_where_no_row_fails_nothing_is_said_of_stiffer_walls(self):
        done = run("zwidth", EXAMPLE, "--criterion", "time", "--damping", "5e-4", "--stiffness", "0.1,0.2")
        self.assertIn("above 0.2", done.stdout)

    def test_errors_say_what_is_expected(self):
        for arguments, words in ((["--gesture", "kick"], "gesture 'kick'"), (["--stiffness", "2..1"], "must rise"),
                                 (["--duration", "1 ms"], "samples"), (["--duration", "1e6 s"], "samples"),
                                 (["--stiffness=-1..1"], "0 or more"), (["--stiffness", "0.1,0.2", "--rows", "9"], "rows")):
            done = run("zwidth", EXAMPLE, "--criterion", "time", "--points", "2", *arguments)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(words, done.stderr)


if __name__ == "__main__":
    unittest.main()
