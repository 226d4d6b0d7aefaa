"""The site's navigation: docs/README.md's questions, and the pages that answer them."""
import pathlib
import re

LINK = re.compile(r"\[([^\]]+)\]\(([^)#\s]+\.md)\)")
QUESTION = re.compile(r"^\*\*(.+?)\*\*", re.MULTILINE)


def navigation(index):
    """index: docs/README.md as the site has it. A list as mkdocs wants it."""
    nav, seen = [{"Start": "index.md"}, {"All pages": "docs/README.md"}], {"index.md", "docs/README.md"}
    questions = list(QUESTION.finditer(index))
    for words, target in LINK.findall(index[:questions[0].start()]):
        seen.add(as_in_site(target))
        nav.append({words.capitalize(): as_in_site(target)})
    for question, after in zip(questions, [*questions[1:], None]):
        pages = []
        for words, target in LINK.findall(index[question.end():after.start() if after else len(index)]):
            place = as_in_site(target)
            if place not in seen:
                seen.add(place)
                pages.append({" ".join(words.split()).strip("`"): place})
        if pages:
            nav.append({question[1]: pages})
    return nav


def as_in_site(target):
    parts = []
    for part in pathlib.PurePosixPath("docs", target).parts:
        if part == "..":
            parts.pop()
        else:
            parts.append(part)
    return "/".join(parts)
