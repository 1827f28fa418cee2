"""The links of documentation and studies: every one leads to a file, and every page can be reached from the README."""
import os
import re
import unittest
from pathlib import Path
from urllib.parse import unquote

from program import ROOT

LINK = re.compile(r"\]\(\s*<?([^)>\s]+)>?[^)]*\)")
CODE = re.compile(r"^```.*?^```|^    .*?$|`[^`\n]*`", re.MULTILINE | re.DOTALL)


def pages():
    return [ROOT / "README.md", *sorted((ROOT / "docs").glob("**/*.md")), *sorted((ROOT / "studies").glob("**/*.md"))]


def headings(page):
    """The anchors that a forge gives to a page's headings."""
    titles = re.findall(r"^#+ +(.*)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def links(page):
    """Target and anchor of every relative link; links within code are text."""
    for target in LINK.findall(CODE.sub("", page.read_text())):
        if not re.match(r"[a-z][a-z0-9+.-]*:", target):
            path, _, anchor = unquote(target).partition("#")
            yield Path(os.path.normpath(page.parent / path)) if path else page, anchor


class LinksTest(unittest.TestCase):

    def test_every_relative_link_leads_to_a_file_of_the_project_and_to_a_heading(self):
        self.assertGreater(sum(len(list(links(page))) for page in pages()), 50)
        for page in pages():
            for target, anchor in links(page):
                with self.subTest(page=str(page.relative_to(ROOT)), link=str(target)):
                    self.assertTrue(target.is_relative_to(ROOT), "outside of the project")
                    self.assertTrue(target.exists(), "no such file")
                    if anchor:
                        self.assertIn(anchor, headings(target))

    def test_every_page_can_be_reached_from_the_readme(self):
        reached, left = set(), [ROOT / "README.md"]
        while left:
            page = left.pop()
            if page not in reached:
                reached.add(page)
                left += [target for target, _ in links(page) if target.suffix == ".md" and target.exists()]
        self.assertEqual([str(p.relative_to(ROOT)) for p in pages() if p not in reached], [])


if __name__ == "__main__":
    unittest.main()
