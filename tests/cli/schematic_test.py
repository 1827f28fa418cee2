"""The schematic: a picture that stands alone, with the model's values in it."""
import json
import re
import subprocess
import unittest
import xml.etree.ElementTree as ElementTree

from program import RC_DISPLAY, ROOT, ProgramTest, example_models, load_example, program, with_value

PICTURES = ROOT / "docs/images/schematics"
SVG = "{http://www.w3.org/2000/svg}"


def texts(svg):
    """Every text as a reader sees it, subscripts on the line."""
    return ["".join(element.itertext()) for element in ElementTree.fromstring(svg).iter(SVG + "text")]


class SchematicTest(ProgramTest):

    def draw(self, model):
        answer = self.run_program("schematic", model, "-o", "out.svg")
        self.assertEqual((answer.code, answer.out, answer.err), (0, "out.svg\n", ""), answer)
        return (self.folder / "out.svg").read_text()

    def test_every_example_is_drawn_as_one_well_formed_picture_that_loads_nothing(self):
        for model in example_models():
            svg = self.draw(model)
            root = ElementTree.fromstring(svg)
            with self.subTest(model=model.name):
                self.assertEqual(root.tag, SVG + "svg")
                name = json.loads(model.read_text())["name"]
                self.assertEqual(root.find(SVG + "title").text, name)
                self.assertIn(name, texts(svg))
                self.assertGreater(len(root.find(SVG + "desc").text), 100)
                self.assertEqual(root.find(SVG + "rect").get("fill"), "#ffffff")  # legible on a dark page
                self.assertNotRegex(svg, r"<script|<image|<style|href|url\(|@import")
                self.assertEqual(re.findall(r"https?://[^\"]+", svg), ["http://www.w3.org/2000/svg"])

    def test_the_values_of_the_model_are_in_it(self):
        shown = texts(self.draw(RC_DISPLAY))
        for text in ("Rm", "1.5 Ω", "Lm", "500 µH", "Kt", "50 mN·m/A", "R1", "5 Ω", "C1", "2.2 mF", "J", "2×10⁻⁵ kg·m²",
                     "b", "100 µN·m·s/rad", "T 1 ms", "K 400 mN·m/rad", "B 150 µN·m·s/rad", "operator: free"):
            self.assertIn(text, shown)

    def test_without_a_file_it_is_printed_and_always_the_same(self):
        printed = self.run_program("schematic", RC_DISPLAY)
        self.assertEqual((printed.code, printed.err), (0, ""))
        self.assertEqual(printed.out, self.draw(RC_DISPLAY))
        self.assertEqual(self.run_program("schematic", RC_DISPLAY, "--svg", "other.svg", "--quiet").out, "")
        self.assertEqual((self.folder / "other.svg").read_text(), printed.out)

    def test_a_name_is_text_and_nothing_else(self):
        name = "<script>alert(1)</script> & 'q' \"Q\""
        svg = self.draw(self.write_model(with_value(load_example(), "/name", name)))
        self.assertIn(name, texts(svg))
        self.assertNotIn("<script", svg)

    def test_what_cannot_be_written_is_refused_and_leaves_nothing(self):
        for options, words in ((["-o", "z.png"], ["--output", "z.png", "must end in .svg"]),
                               (["--svg", "z"], ["--svg", "must end in .svg"]),
                               (["-o", "missing/z.svg"], ["missing/z.svg", "cannot be written"]),
                               (["-o", ""], ["--output"]),
                               (["-o", "a.svg", "--svg", "b.svg"], ["--svg", "--output"])):
            with self.subTest(options=options):
                self.assert_refused(self.run_program("schematic", RC_DISPLAY, *options), *words)
        self.assertEqual(self.files(), [])

    def test_a_bad_model_keeps_the_last_picture(self):
        (self.folder / "out.svg").write_text("the last one\n")
        name = self.write_model(with_value(load_example(), "/motor/resistance", "5 H"))
        self.assert_refused(self.run_program("schematic", name, "-o", "out.svg"), "/motor/resistance")
        self.assertEqual((self.folder / "out.svg").read_text(), "the last one\n")

    def test_the_report_begins_with_the_device(self):
        self.run_program("impedance", RC_DISPLAY, "--points", "5", "--quiet", "-o", "a.json")
        self.run_program("impedance", RC_DISPLAY, "--points", "6", "--quiet", "-o", "b.json")
        self.run_program("report", "a.json", "b.json", "-o", "report.html")
        page = (self.folder / "report.html").read_text()
        schematic = self.run_program("schematic", RC_DISPLAY).out
        self.assertEqual(page.count(schematic), 1)  # of the same model in both results
        self.assertLess(page.index(schematic), page.index("<h2>"))

    def test_the_pictures_of_the_documentation_are_the_programs(self):
        done = subprocess.run([ROOT / "docs/draw-schematics", program(), self.folder / "drawn"], cwd=self.folder,
                              capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        drawn = {path.name: path.read_text() for path in (self.folder / "drawn").iterdir()}
        kept = {path.name: path.read_text() for path in PICTURES.iterdir()}
        self.assertIn("rc_display.svg", drawn)
        self.assertLessEqual(set(drawn), set(kept), "run docs/draw-schematics and keep what it draws")
        if (ROOT / "docs/drives/models").exists():
            self.assertLessEqual(set(kept), set(drawn), "pictures of models that are gone")
        for name, svg in drawn.items():
            self.assertEqual(svg, kept[name], f"{name}: run docs/draw-schematics and keep what it draws")


if __name__ == "__main__":
    unittest.main()
