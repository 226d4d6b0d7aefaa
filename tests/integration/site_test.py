#!/usr/bin/python3
"""scripts/site finds the link that leads nowhere, and lays the pages' links and lists as its builder wants them."""
import pathlib
import sys
import tempfile
import unittest

import daemons

sys.path.append(str(daemons.ROOT / "scripts" / "pages"))
import links
import navigation
import source


class SiteTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stillgrid-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def faults_of(self, **pages):
        for name, text in pages.items():
            (self.folder / f"{name}.html").write_text(f"<html><body>{text}</body></html>")
        return list(links.faults(self.folder))

    def test_a_dead_link_a_dead_anchor_and_what_is_fetched_from_elsewhere_are_told(self):
        whole = '<h2 id="here">x</h2><a href="#here">x</a><a href="b.html#there">x</a><a href="https://a.org/">x</a>'
        self.assertEqual(self.faults_of(a=whole, b='<p id="there"></p><img src="a.html">'), [])
        for bad, words in (('<a href="c.html">', "c.html"), ('<a href="b.html#gone">', "b.html#gone"),
                           ('<a href="#gone">', "#gone"), ('<img src="c.png">', "c.png"),
                           ('<script src="https://cdn.org/x.js"></script>', "cdn.org"),
                           ('<link rel="stylesheet" href="//fonts.org/x.css">', "fonts.org")):
            with self.subTest(bad):
                (line,) = self.faults_of(a=whole + bad)
                self.assertTrue(line.startswith("a.html: ") and words in line, line)

    def test_links_lead_to_pages_and_source_files_to_the_repository_or_nowhere(self):
        page = source.ROOT / "docs/architecture.md"
        for link, alone, with_repository in (
                ("[x](../README.md#folders)", "[x](../index.md#folders)", None),
                ("[x](viewer.md)", "[x](viewer.md)", None), ("[x](#tick)", "[x](#tick)", None),
                ("[a b](../shared/collision/)", "a b", "[a b](https://r.org/s/blob/main/shared/collision)"),
                ("[x](decisions/)", "[x](decisions/index.md)", None), ("[x](https://a.org)", "[x](https://a.org)", None)):
            with self.subTest(link):
                match = source.LINK.search(link)
                self.assertEqual(source.laid_anew(match, page, ""), alone)
                self.assertEqual(source.laid_anew(match, page, "https://r.org/s"), with_repository or alone)
        with self.assertRaisesRegex(ValueError, r"docs/architecture.md: link 'gone.md'"):
            source.laid_anew(source.LINK.search("[x](gone.md)"), page, "")

    def test_a_list_below_a_paragraph_is_one_and_a_fence_is_left_alone(self):
        file = self.folder / "page.md"
        file.write_text("Words:\n* one\n  more\n* two\n\n```\nWords:\n* one [x](gone)\n```\n")
        self.assertEqual(source.text_of(file, ""), "Words:\n\n* one\n  more\n* two\n\n```\nWords:\n* one [x](gone)\n```\n")

    def test_a_file_of_a_tutorial_is_named_above_its_code_and_what_is_for_its_test_is_left_out(self):
        file = self.folder / "page.md"
        file.write_text("```toml build/mine/a.toml\na = 1\n```\n```sh fails 3\nfalse\n```\n  ```\n  x\n  ```\n")
        self.assertEqual(source.text_of(file, ""), '```toml title="build/mine/a.toml"\na = 1\n```\n```sh\nfalse\n```\n'
                         "  ```\n  x\n  ```\n")

    def test_every_page_has_its_place_in_the_navigation_once(self):
        nav = navigation.navigation((source.ROOT / "docs/README.md").read_text())
        places = [place for entry in nav for value in entry.values()
                  for place in ([value] if isinstance(value, str) else [page for one in value for page in one.values()])]
        self.assertEqual(len(places), len(set(places)))
        pages = {file.relative_to(source.ROOT).as_posix() for file in (source.ROOT / "docs").rglob("*.md")
                 if "decisions" not in file.parts and "examples" not in file.parts}
        self.assertEqual(pages - set(places), set())


if __name__ == "__main__":
    daemons.main()
