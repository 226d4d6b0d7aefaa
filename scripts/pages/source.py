"""What the site's builder reads: the repository's pages, links laid anew, lists as it wants them."""
import os
import pathlib
import re
import shutil

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOP_PAGES = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "CODE_OF_CONDUCT.md", "SECURITY.md",
             "THIRD_PARTY_NOTICES.md")
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\]|!\[[^\]]*\]\([^)]*\))*)\]\(([^()\s]+)\)")
FENCE = re.compile(r"^(```|~~~)")
LIST_ITEM = re.compile(r"^\s*([*+-]|\d+\.) ")


def place_of(file):
    """Where a file of the repository lies in the site's source; None: it is no part of it."""
    path = file.relative_to(ROOT)
    if path.as_posix() == "README.md":
        return pathlib.Path("index.md")
    if path.as_posix() == "LICENSE":
        return pathlib.Path("LICENSE.md")
    if path.as_posix() in TOP_PAGES or path.parts[0] == "docs" and "examples" not in path.parts:
        return path
    return None


def laid_anew(link, file, repository):
    """A link of a page of the repository as it is in the site: to a page, to the repository, or its words alone."""
    mark, words, target = link.groups()
    path, _, anchor = target.partition("#")
    if not path or re.match(r"[a-z]+:", target):
        return link[0]
    to = (file.parent / path).resolve()
    if not to.exists():
        raise ValueError(f"{file.relative_to(ROOT)}: link '{target}': expected a file of the repository")
    if to == ROOT / "docs/decisions":
        to = to / "index.md"
    place = place_of(to) if to.is_file() or to.name == "index.md" else None
    if place is None:
        if mark:
            raise ValueError(f"{file.relative_to(ROOT)}: picture '{target}': expected one under docs/")
        return f"[{words}]({repository}/blob/main/{to.relative_to(ROOT)})" if repository else words
    relative = os.path.relpath(place, place_of(file).parent)
    return f"{mark}[{words}]({relative}{'#' if anchor else ''}{anchor})"


def text_of(file, repository):
    """A page, outside of its fences: links laid anew, a blank line before each list, as Python's Markdown wants it."""
    text, prose, is_code = [], [], False

    def end_prose():
        text.append(LINK.sub(lambda link: laid_anew(link, file, repository), with_blank_lines(prose)))
        prose.clear()

    for line in file.read_text(encoding="utf-8").splitlines(keepends=True):
        is_fence = bool(FENCE.match(line.lstrip()))
        if is_fence and not is_code:
            end_prose()
        (text if is_code or is_fence else prose).append(with_title(line) if is_fence else line)
        is_code ^= is_fence
    end_prose()
    return "".join(text)


def with_title(fence):
    """A fence that begins a file of a tutorial names it above the code; its other words are for the test alone."""
    marks, words = re.fullmatch(r"(\s*(?:```|~~~))(.*)\n?", fence).groups()
    language, *rest = words.split() or [""]
    title = f' title="{rest[0]}"' if len(rest) == 1 and "/" in rest[0] else ""
    return f"{marks}{language}{title}\n"


def with_blank_lines(lines):
    result, before = [], ""
    for line in lines:
        if (LIST_ITEM.match(line) and before.strip() and not LIST_ITEM.match(before) and not before.startswith(" ")
                and not before.startswith("|")):
            result.append("\n")
        result.append(line)
        before = line
    return "".join(result)


def write_source(folder, repository):
    """All pages and pictures, where the site's builder looks for them."""
    shutil.rmtree(folder, ignore_errors=True)
    for file in sorted([*(ROOT / name for name in TOP_PAGES), *(ROOT / "docs").rglob("*")]):
        place = place_of(file) if file.is_file() else None
        if place is None or file.name == "Doxyfile":
            continue
        to = folder / place
        to.parent.mkdir(parents=True, exist_ok=True)
        if file.suffix == ".md":
            to.write_text(text_of(file, repository), encoding="utf-8")
        else:
            shutil.copyfile(file, to)
    (folder / "LICENSE.md").write_text(f"# Licence\n\n```\n{(ROOT / 'LICENSE').read_text()}```\n")
    (folder / "docs/decisions/index.md").write_text(decisions())
    charts = folder / "docs/charts/README.md"
    charts.write_text(with_grid(charts.read_text(encoding="utf-8")), encoding="utf-8")


def title_of(file):
    return next(line[2:].strip() for line in file.read_text(encoding="utf-8").splitlines() if line.startswith("# "))


def decisions():
    files = sorted((ROOT / "docs/decisions").glob("*.md"))
    return "# Decisions\n\n" + "".join(f"* [{title_of(file)}]({file.name})\n" for file in files)


def with_grid(page):
    """Above the charts all of them at a glance, each a link to its place."""
    figures, anchor, title = [], "", ""
    for line in page.splitlines():
        if line.startswith("### "):
            title = line[4:].strip()
            anchor = slug(title, "-")
        picture = re.match(r"!\[[^\]]*\]\(([^)]+)\)", line)
        if picture and anchor:
            figures.append(f'<a href="#{anchor}"><img src="{picture[1]}" alt="" loading="lazy"><span>{title}</span></a>')
            anchor = ""
    head, rest = page.split("\n* ", 1)
    return f"{head}\n<div class=\"charts\">\n" + "\n".join(figures) + f"\n</div>\n\n* {rest}"


def slug(text, separator):
    """A heading's anchor, as where the repository's pages are read else."""
    return re.sub(r"[^\w\- ]", "", re.sub(r"<[^>]*>", "", text).strip().lower()).replace(" ", separator)
