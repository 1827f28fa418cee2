"""The figures' script and style in the source tree are made from the sources beside them."""
import hashlib
import json
import re
import unittest

from program import ROOT

WEB = ROOT / "web"
MADE = ROOT / "src/gyrator/plots/web"


class WebBundle(unittest.TestCase):
    def test_script_and_style_belong_to_their_sources(self):
        names = ["build.mjs", "figures.css", "package-lock.json", "package.json",
                 *(f"src/{path.name}" for path in (WEB / "src").iterdir())]
        digest = hashlib.sha256()
        for name in sorted(names):
            digest.update(f"{name}\n".encode() + (WEB / name).read_bytes())
        for name in ("figures.js", "figures.css"):
            self.assertIn(f"Sources: sha256 {digest.hexdigest()}", (MADE / name).read_text(),
                          f"{name} is older than web/: run web/build")

    def test_it_names_its_library_and_carries_the_licence(self):
        versions = json.loads((WEB / "package.json").read_text())["devDependencies"]
        script = (MADE / "figures.js").read_text()
        self.assertIn(f"with uPlot {versions['uplot']} and esbuild {versions['esbuild']}", script)
        self.assertIn((MADE / "LICENSE-uPlot").read_text().strip(), script)

    def test_the_lock_holds_every_package_by_its_digest_and_no_address(self):
        text = (WEB / "package-lock.json").read_text()
        self.assertIsNone(re.search("https?:", text))
        packages = json.loads(text)["packages"]
        self.assertIn("node_modules/uplot", packages)
        for name, package in packages.items():
            if name:
                self.assertTrue(package["integrity"].startswith("sha512-"), name)


if __name__ == "__main__":
    unittest.main()
