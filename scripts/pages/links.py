"""Whether a folder of HTML holds together by itself: each link leads to a page and an anchor that are there, and
nothing is fetched from elsewhere."""
import html.parser
import pathlib
import re
import urllib.parse

FETCHED = {("script", "src"), ("link", "href"), ("img", "src"), ("iframe", "src"), ("source", "src")}
NO_FETCH = {"canonical", "next", "prev"}


class Page(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.anchors, self.links, self.fetched = set(), [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.anchors.update(found[name] for name in ("id", "name") if found.get(name))
        for name in ("href", "src"):
            if not found.get(name) or tag == "link" and found.get("rel") in NO_FETCH:
                continue
            (self.fetched if (tag, name) in FETCHED else self.links).append(found[name])


def faults(folder):
    """A line each; of the API reference only that it is there, for Doxygen checks its own."""
    folder = pathlib.Path(folder)
    pages = {file: Page(file.read_text(encoding="utf-8")) for file in sorted(folder.rglob("*.html"))
             if "api" not in file.relative_to(folder).parts[:1]}
    for file, page in pages.items():
        if file.name == "404.html":
            continue
        name = file.relative_to(folder)
        for target in page.fetched:
            if re.match(r"([a-z]+:)?//", target):
                yield f"{name}: fetches '{target}': expected a file of the site"
        for target in [*page.links, *page.fetched]:
            if re.match(r"[a-z]+:|//", target):
                continue
            path, _, anchor = target.partition("#")
            path = urllib.parse.unquote(path.partition("?")[0])
            to = (file.parent / path).resolve() if path else file
            if not to.exists():
                yield f"{name}: link '{target}': expected a page that is there"
            elif anchor and to in pages and urllib.parse.unquote(anchor) not in pages[to].anchors:
                yield f"{name}: link '{target}': expected a heading of that name"
