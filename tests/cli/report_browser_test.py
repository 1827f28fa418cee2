"""A report in headless Chromium: its figures answer the pointer, and what they say is what the results say.

Needs chromium, chromium-driver and Selenium; where this Python has no Selenium, the system's runs the tests.
"""
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.support.ui import WebDriverWait
    HERE = True
except ImportError:
    HERE = False

from program import EXAMPLES, load_example, program

SYSTEM_PYTHON = "/usr/bin/python3"
PATIENCE_S = 60  # for a page to settle on a busy machine; nothing here waits that long when it works
HOSTILE = "</script><img src=x onerror=alert(1)> & <b>bold</b>"
PRINTED = 1e-4  # values are printed to five digits: half of the last is 5e-5 of a number near 1


def number_in(text):
    """The number at the front of a printed quantity, such as "−2.7×10⁻³ N·m"."""
    word = text.split()[0].replace("−", "-")
    mantissa, _, power = word.partition("×10")
    digits = {"⁻": "-"} | {c: str(i) for i, c in enumerate("⁰¹²³⁴⁵⁶⁷⁸⁹")}
    return float(f"{mantissa}e{''.join(digits[c] for c in power) or 0}")


def make_results(folder):
    """Real results of a model with a hostile name, by their command."""
    model = load_example() | {"name": HOSTILE}
    (folder / "model.json").write_text(json.dumps(model))
    first, second = EXAMPLES / "compare/re25_none.json", EXAMPLES / "compare/re25_rc.json"
    commands = {
        "passivity": ["passivity", "model.json", "--simulate-counterexample"],
        "zwidth": ["zwidth", "model.json"],
        "time": ["zwidth", "model.json", "--criterion", "time", "--points", "9", "--rows", "9"],
        "simulate": ["simulate", "model.json"],
        "impedance": ["impedance", "model.json", "--points", "100"],
        "compare": ["compare", first, second, "--points", "12"],
        "stability": ["stability-map", EXAMPLES / "stability_plane.json", "--points", "6"],
        "tolerance": ["tolerance", EXAMPLES / "rc_display_tolerance.json", "--samples", "20"],
    }
    results = {}
    for name, words in commands.items():
        done = subprocess.run([program(), *words, "-o", f"{name}.json", "--quiet"], cwd=folder,
                              capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        if done.returncode not in (0, 1):
            raise RuntimeError(f"gyrator {words}: {done.stderr}")
        results[name] = json.loads((folder / f"{name}.json").read_text())
    # Texts that end up in titles of panels, names of curves and units of axes.
    results["passivity"]["units"]["inertia"] = HOSTILE
    results["compare"]["designs"][0]["name"] = HOSTILE
    results["compare"]["units"]["stiffness"] = HOSTILE
    for name in ("passivity", "compare"):
        (folder / f"{name}.json").write_text(json.dumps(results[name]))
    subprocess.run([program(), "report", *[f"{name}.json" for name in commands], "-o", "page.html"],
                   cwd=folder, check=True, timeout=PATIENCE_S, stdout=subprocess.DEVNULL)
    return results


def start_browser():
    browser, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if not browser or not driver:
        raise RuntimeError("no browser (Debian: chromium, chromium-driver)")
    options = Options()
    options.binary_location = browser
    # Not as root and not with little shared memory would it start otherwise.
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu",
                     "--window-size=1200,900"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(service=Service(driver), options=options)


class ReportInABrowser(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="gyrator-report-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        cls.results = make_results(cls.folder)
        cls.browser = start_browser()
        cls.addClassCleanup(cls.browser.quit)

    def setUp(self):
        self.use_screen(1200)
        self.open_page()

    def use_screen(self, width, media=""):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False})
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": media})

    def open_page(self):
        self.browser.get("about:blank")
        self.browser.get_log("browser")  # what the page before may have said
        self.browser.get((self.folder / "page.html").as_uri())
        count = len(self.browser.find_elements("css selector", "figure.interactive"))
        self.wait(lambda: len(self.browser.find_elements("css selector", "figure.live")) == count,
                  "not every figure became interactive")

    def wait(self, condition, message):
        WebDriverWait(self.browser, PATIENCE_S, poll_frequency=0.05).until(lambda _: condition(), message)

    def script(self, text, *arguments):
        return self.browser.execute_script(text, *arguments)

    def panels_of(self, result):
        """The panels of a result's figure; the finding's is the first on the page."""
        at = 1 + list(self.results).index(result)
        figure = self.browser.find_elements("css selector", "figure.interactive")[at]
        return figure.find_elements("css selector", ".panel")

    def pointer(self):
        return ActionChains(self.browser, duration=50)  # ms for a move

    def view(self, panel):
        return self.script("const {x, y} = arguments[0].plot.scales;"
                           "return {x: [x.min, x.max], y: [y.min, y.max]};", panel)

    def over(self, panel):
        over = panel.find_element("css selector", ".u-over")
        self.script("arguments[0].scrollIntoView({block: 'center'})", over)
        return over

    def position(self, panel, x, y):
        """Pixels from the middle of the frame to a point in units of the axes."""
        return self.script(
            "const [panel, x, y] = arguments; const u = panel.plot;"
            "return [Math.round(u.valToPos(x, 'x') - u.over.clientWidth / 2),"
            "        Math.round(u.valToPos(y, 'y') - u.over.clientHeight / 2)];", panel, x, y)

    def point_at(self, panel, x, y):
        """Puts the pointer there; what the panel then says: x on top, and one text for each curve."""
        over = self.over(panel)
        right, down = self.position(panel, x, y)
        self.pointer().move_to_element_with_offset(over, right, down).perform()
        readout = panel.find_element("css selector", ".readout")
        self.wait(lambda: readout.text.strip(), "nothing is said of the pointer's place")
        rows = panel.find_elements("css selector", ".u-series")
        said = {row.find_element("css selector", ".u-label").text:
                row.find_element("css selector", ".u-value").text for row in rows}
        return readout.text, said

    def drag(self, panel, start, end):
        over = self.over(panel)
        self.pointer().move_to_element_with_offset(over, *start).click_and_hold() \
            .move_by_offset((end[0] - start[0]) // 2, (end[1] - start[1]) // 2) \
            .move_to_element_with_offset(over, *end).release().perform()

    def assert_view(self, panel, expected, share=1e-9):
        """Both ranges, to a share of their lengths along the axes."""
        forward = {key: math.log if logarithmic else float for key, logarithmic in self.script(
            "const {x, y} = arguments[0].plot.scales; return {x: x.distr === 3, y: y.distr === 3};", panel).items()}

        def near():
            view = self.view(panel)
            for key in "xy":
                (low, high), (a, b) = map(forward[key], expected[key]), map(forward[key], view[key])
                if max(abs(a - low), abs(b - high)) > share * (high - low):
                    return False
            return True
        self.wait(near, f"expected {expected}, is {self.view(panel)}")

    # ---- the page as a whole

    def test_it_opens_without_a_word_in_the_console_and_loads_nothing(self):
        self.assertEqual(self.browser.get_log("browser"), [])
        self.assertEqual(self.script("return performance.getEntriesByType('resource').map(e => e.name)"), [])
        figures = self.browser.find_elements("css selector", "figure.interactive")
        self.assertEqual(len(figures), 1 + len(self.results))
        for figure in figures:
            data = json.loads(self.script(
                "return arguments[0].querySelector('.figure-data').textContent", figure))
            canvases = figure.find_elements("css selector", "canvas")
            self.assertEqual(len(canvases), len(data["panels"]))
            for canvas in canvases:
                self.assertTrue(canvas.is_displayed())
                self.assertGreater(canvas.size["width"], 200)
            self.assertFalse(figure.find_element("css selector", ".picture").is_displayed())

    def test_a_hostile_name_is_shown_as_text_and_the_page_runs_no_script_but_its_own(self):
        self.assertEqual(self.browser.find_element("css selector", "h1").text, HOSTILE)
        title = self.panels_of("passivity")[4].find_element("css selector", ".panel-title").text
        self.assertIn(HOSTILE, title)  # of the operator's inertia
        compared = self.panels_of("compare")[0]
        self.assertIn(HOSTILE, [label.text for label in compared.find_elements("css selector", ".u-label")])
        design = self.results["compare"]["designs"][0]
        _, said = self.point_at(compared, design["damping"][2], design["max_stiffness"][2])
        self.assertIn("onerror", said[HOSTILE])  # the unit
        self.assertEqual(self.browser.find_elements("css selector", "img, b"), [])
        self.browser.get_log("browser")
        self.script("const s = document.createElement('script'); s.textContent = 'window.taken = 1';"
                    "document.body.append(s);"
                    "const i = document.createElement('img'); i.src = 'https://example.invalid/x.png';"
                    "document.body.append(i)")
        refusals = []

        def refused():
            refusals.extend(entry["message"] for entry in self.browser.get_log("browser"))
            return len(refusals) >= 2
        self.wait(refused, "the browser did not refuse a foreign script and a picture from elsewhere")
        self.assertTrue(all("Content Security Policy" in text for text in refusals), refusals)
        self.assertIsNone(self.script("return window.taken ?? null"))

    def test_in_print_and_without_script_the_pictures_are_there(self):
        self.use_screen(800, media="print")
        for figure in self.browser.find_elements("css selector", "figure.interactive"):
            self.assertTrue(figure.find_element("css selector", ".picture svg").is_displayed())
            self.assertFalse(figure.find_element("css selector", ".plots").is_displayed())
            self.assertFalse(figure.find_element("css selector", ".hint").is_displayed())
        self.use_screen(1200)
        text = (self.folder / "page.html").read_text()
        start, end = text.index("<script>"), text.rindex("</script>")
        (self.folder / "scriptless.html").write_text(text[:start] + text[end + len("</script>"):])
        self.browser.get((self.folder / "scriptless.html").as_uri())
        pictures = self.browser.find_elements("css selector", "figure.interactive .picture svg")
        self.assertEqual(len(pictures), 1 + len(self.results))
        self.assertTrue(all(picture.is_displayed() for picture in pictures))

    def test_on_a_phone_nothing_is_wider_than_the_screen(self):
        self.use_screen(390)
        canvases = self.browser.find_elements("css selector", "figure.live canvas")
        self.wait(lambda: all(canvas.size["width"] <= 390 for canvas in canvases),
                  "a plot stays wider than the screen")
        self.assertLessEqual(self.script("return document.documentElement.scrollWidth"), 390)
        for canvas in canvases:
            self.assertGreater(canvas.size["width"], 250)
        self.use_screen(1200)
        self.wait(lambda: canvases[0].size["width"] > 400, "a plot stays narrow on a wide screen")

    # ---- values

    def test_over_a_boundary_it_says_the_limits_of_the_result(self):
        panel = self.panels_of("zwidth")[0]
        boundaries = {b["criterion"]: b for b in self.results["zwidth"]["boundaries"]}
        exact = boundaries["exact_disk"]
        for i in (len(exact["damping"]) // 3, len(exact["damping"]) // 4):  # samples are 10 pixels apart
            top, said = self.point_at(panel, 1e6 * exact["damping"][i], exact["max_stiffness"][i])
            self.assertTrue(top.startswith("virtual damping B "), top)
            self.assertTrue(top.endswith(" N·m·s/rad"), top)
            b = number_in(top.removeprefix("virtual damping B "))
            for title, criterion in (("true limit, exact aliased disk", "exact_disk"),
                                     ("textbook, Re Z + bᵥ > 0", "frequency_dependent")):
                boundary = boundaries[criterion]
                text = said[title]
                self.assertIn("N·m/rad", text)
                at = number_in(text.split(" at ")[1]) if " at " in text else b
                nearest = min(range(len(boundary["damping"])),
                              key=lambda j, xs=boundary["damping"]: abs(xs[j] - exact["damping"][i]))
                self.assertAlmostEqual(at, boundary["damping"][nearest], delta=PRINTED * abs(at))
                self.assertAlmostEqual(number_in(text), boundary["max_stiffness"][nearest],
                                       delta=PRINTED * boundary["max_stiffness"][nearest])

    def test_on_logarithmic_axes_it_says_the_impedance_of_the_result(self):
        panel = self.panels_of("impedance")[0]
        result = self.results["impedance"]
        for i in (20, 50, 80):  # of 100: samples are six pixels apart
            z = complex(result["impedance_real"][i], result["impedance_imag"][i])
            top, said = self.point_at(panel, result["frequency_hz"][i], abs(z))
            for text, value in ((top.removeprefix("frequency "), result["frequency_hz"][i]), (said["|Z|"], abs(z)),
                                (said["Re Z, effective damping"], z.real)):
                self.assertAlmostEqual(number_in(text), value, delta=PRINTED * value)

    def test_a_held_command_is_the_last_sample_before_the_pointer(self):
        panel = self.panels_of("simulate")[2]
        trace = self.results["simulate"]["trace"]
        period = trace["time_s"][1]
        self.drag(panel, (-30, 0), (30, 4))
        self.wait(lambda: self.view(panel)["x"][1] - self.view(panel)["x"][0] < 60 * period, "no zoom")
        low, high = self.view(panel)["x"]  # samples are more than ten pixels apart now
        i = round((low + high) / 2 / period)
        _, said = self.point_at(panel, trace["time_s"][i] + 0.8 * period, 0)  # nearer to the next one
        text = said["command"]
        value = trace["held_command_after"][i]
        self.assertAlmostEqual(number_in(text), value, delta=PRINTED * abs(value))
        self.assertAlmostEqual(number_in(text.split(" at ")[1]), trace["time_s"][i], delta=PRINTED * trace["time_s"][i])

    def test_a_cell_of_the_map_says_which_outcome_it_is(self):
        panel = self.panels_of("time")[0]
        boundary = self.results["time"]["boundaries"][0]
        names = {"settles": "settles", "limit_cycle": "limit cycle", "diverges": "diverges"}
        seen = set()
        for row in (0, 4, 8):
            for column in (1, 7):
                outcome = names[boundary["map"]["outcome_names"][boundary["map"]["outcome"][row][column]]]
                _, said = self.point_at(panel, 1e6 * boundary["damping"][column],
                                        boundary["map"]["stiffness"][row])
                here = {name for name in names.values() if said.get(name)}
                self.assertEqual(here, {outcome})
                seen.add(outcome)
        self.assertGreater(len(seen), 1)

    def test_shading_says_that_it_is_there_and_nothing_beside_it(self):
        panel = self.panels_of("passivity")[0]
        over_frequency = self.results["passivity"]["damping_over_frequency"]
        exact = over_frequency["exact"]
        for wanted, here in ((2, "here"), (200, "")):
            i = min(range(len(exact)), key=lambda j, f=wanted: abs(over_frequency["frequency_hz"][j] - f))
            self.assertEqual(exact[i] < 0, bool(here))
            _, said = self.point_at(panel, over_frequency["frequency_hz"][i], 0)
            self.assertEqual(said["fails here (exact)"], here)

    def test_of_points_in_the_plane_only_the_one_at_the_pointer_answers(self):
        panel = self.panels_of("stability")[0]
        result = self.results["stability"]
        names = {"passive": "comes to rest", "locally_stable": "rests after a small kick only",
                 "limit_cycle": "limit cycle", "unstable": "unstable"}
        seen = set()
        for row, column in ((0, 0), (0, 5), (2, 3), (5, 4), (4, 0)):  # points are 100 pixels apart
            name = names[result["region"][row][column]]
            _, said = self.point_at(panel, result["beta"][column], result["sigma"][row])
            self.assertEqual({text for text in names.values() if said.get(text)}, {name})
            self.assertAlmostEqual(number_in(said[name]), result["sigma"][row], delta=PRINTED)
            seen.add(name)
        self.assertGreater(len(seen), 1)

    def test_a_bar_says_its_part_and_where_it_ends(self):
        panel = self.panels_of("tolerance")[1]
        parts = self.results["tolerance"]["parts"]  # the strongest on top
        nominal = self.results["tolerance"]["nominal"]["max_stiffness"]
        for i in (0, 1):
            low = parts[i]["max_stiffness_at_low"]
            top, said = self.point_at(panel, low + 0.25 * (nominal - low), len(parts) - i)
            self.assertEqual(said, {"at the low end": parts[i]["name"], "at the high end": ""})
            self.assertAlmostEqual(number_in(top.removeprefix("K ")), low, delta=PRINTED * low)

    # ---- view

    def test_a_drag_shows_the_dragged_part_and_a_double_click_all_of_it(self):
        panel = self.panels_of("compare")[0]
        home = self.view(panel)
        start, end = (-200, -100), (120, 80)
        value = "const u = arguments[0].plot; return u.posToVal(" \
                "arguments[1] + u.over[arguments[2] == 'x' ? 'clientWidth' : 'clientHeight'] / 2, arguments[2])"
        expected = {"x": [self.script(value, panel, p[0], "x") for p in (start, end)],
                    "y": [self.script(value, panel, p[1], "y") for p in (end, start)]}
        all_button = panel.find_elements("css selector", "button")[2]
        self.assertFalse(all_button.is_enabled())
        self.drag(panel, start, end)
        self.assert_view(panel, expected, share=2 / 180)  # two pixels, of the shorter side of what was dragged
        self.assertTrue(all_button.is_enabled())
        self.pointer().double_click(self.over(panel)).perform()
        self.assert_view(panel, home)
        self.assertFalse(all_button.is_enabled())

    def test_a_drag_along_time_moves_all_panels_of_the_run_and_no_other_figure(self):
        position, velocity, *_ = self.panels_of("simulate")
        others = self.panels_of("passivity")
        before = [self.view(panel) for panel in others]
        height = self.view(position)["y"]
        self.drag(position, (-150, 0), (100, 4))
        self.wait(lambda: self.view(position)["x"][1] < 0.45, "the drag did nothing")
        view = self.view(position)
        self.assertEqual(view["y"], height)
        self.assertEqual(self.view(velocity)["x"], view["x"])
        self.assertEqual([self.view(panel) for panel in others], before)

    def test_the_cursor_is_at_the_same_time_on_all_panels_of_the_run(self):
        position, velocity, *_ = self.panels_of("simulate")
        trace = self.results["simulate"]["trace"]
        top, _ = self.point_at(position, trace["time_s"][200], 0)
        readout = velocity.find_element("css selector", ".readout")
        self.wait(lambda: readout.text == top, f"{readout.text}, not {top}")
        i = min(range(len(trace["time_s"])), key=lambda j: abs(trace["time_s"][j] - number_in(top)))
        self.assertAlmostEqual(number_in(velocity.find_element("css selector", ".u-value").text),
                               trace["velocity"][i], delta=PRINTED * abs(trace["velocity"][i]))

    def test_a_disk_is_round_also_after_zooming(self):
        disk = self.panels_of("passivity")[2]

        def aspect():
            return self.script(
                "const u = arguments[0].plot; const {x, y} = u.scales;"
                "return (x.max - x.min) / u.bbox.width / ((y.max - y.min) / u.bbox.height);", disk)
        self.wait(lambda: abs(aspect() - 1) < 0.01, f"one unit of x is {aspect()} of one of y")
        span = self.view(disk)["x"][1] - self.view(disk)["x"][0]
        self.drag(disk, (-90, -50), (60, 90))
        self.wait(lambda: self.view(disk)["x"][1] - self.view(disk)["x"][0] < 0.8 * span, "no zoom")
        self.wait(lambda: abs(aspect() - 1) < 0.01, f"one unit of x is {aspect()} of one of y")
        for _ in range(2):  # the numbers at the axis need more room, and the frame has less
            span = self.view(disk)["x"][1] - self.view(disk)["x"][0]
            self.drag(disk, (-20, -20), (14, 14))
            self.wait(lambda: self.view(disk)["x"][1] - self.view(disk)["x"][0] < 0.5 * span, "no zoom")
        self.wait(lambda: abs(aspect() - 1) < 0.01, f"one unit of x is {aspect()} of one of y")

    def coloured(self, panel, colour):
        """Pixels of the colour in the panel's frame."""
        return self.script(
            "const u = arguments[0].plot; const {left, top, width, height} = u.bbox;"
            "const copy = document.createElement('canvas'); copy.width = width; copy.height = height;"
            "const c2d = copy.getContext('2d', {willReadFrequently: true});"
            "c2d.drawImage(u.ctx.canvas, left, top, width, height, 0, 0, width, height);"
            "const data = c2d.getImageData(0, 0, width, height).data; let count = 0;"
            "for (let i = 0; i < data.length; i += 4)"
            "  if ([0, 1, 2].every(c => Math.abs(data[i + c] - arguments[1][c]) < 12)) ++count;"
            "return count;", panel, colour)

    def test_a_click_on_a_name_hides_its_curve_and_another_shows_it(self):
        panel = self.panels_of("zwidth")[0]
        blue = [0x00, 0x72, 0xB2]
        self.wait(lambda: self.coloured(panel, blue) > 100, "the curve is not drawn")
        before = self.view(panel)
        name = next(th for th in panel.find_elements("css selector", ".u-series th")
                    if th.text == "true limit, exact aliased disk")
        self.over(panel)
        name.click()
        self.wait(lambda: self.coloured(panel, blue) == 0, "the curve is still there")
        self.assertEqual(name.get_attribute("aria-checked"), "false")
        self.assertEqual(self.view(panel), before)
        name.send_keys(Keys.ENTER)  # as well by keyboard
        self.wait(lambda: self.coloured(panel, blue) > 100, "the curve does not come back")
        self.assertEqual(name.get_attribute("aria-checked"), "true")

    def test_the_keyboard_moves_the_cursor_and_zooms(self):
        panel = self.panels_of("impedance")[0]
        home = self.view(panel)
        over = self.over(panel)
        readout = panel.find_element("css selector", ".readout")
        self.script("arguments[0].focus()", over)
        over.send_keys(Keys.ARROW_RIGHT)
        self.wait(lambda: readout.text.startswith("frequency "), "no value at the cursor")
        first = number_in(readout.text.removeprefix("frequency "))
        over.send_keys(*[Keys.ARROW_RIGHT] * 10)
        self.wait(lambda: number_in(readout.text.removeprefix("frequency ")) > first, "the cursor stays")
        over.send_keys("+")
        self.wait(lambda: self.view(panel)["x"][1] / self.view(panel)["x"][0] < home["x"][1] / home["x"][0] / 2,
                  "no zoom")
        over.send_keys(Keys.ESCAPE)
        self.assert_view(panel, home)


class ReportElsewhere(unittest.TestCase):
    def test_the_systems_python_runs_the_tests_of_this_file(self):
        done = subprocess.run([SYSTEM_PYTHON, "-m", "unittest", Path(__file__).stem], cwd=Path(__file__).parent,
                              env=os.environ | {"GYRATOR": program(), "GYRATOR_LAST_PYTHON": "1"},
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertRegex(done.stdout, r"Ran 1\d tests")


def load_tests(loader, _tests, _pattern):
    if not HERE and os.environ.get("GYRATOR_LAST_PYTHON"):
        raise RuntimeError(f"{sys.executable} has no Selenium (Debian: python3-selenium)")
    return loader.loadTestsFromTestCase(ReportInABrowser if HERE else ReportElsewhere)


if __name__ == "__main__":
    unittest.main()
