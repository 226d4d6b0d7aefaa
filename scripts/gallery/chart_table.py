"""The table of charts, charts.toml, the page that shows it, and hashes of the files that a chart is made of."""
import hashlib
import pathlib
import re
import textwrap
import tomllib

from measuring import DATA, ROOT

HERE = pathlib.Path(__file__).resolve().parent
NOTED = HERE / "made_of.txt"
CPP, PYTHON, HASH_SIGN = r"//[^\n]*|(?s:/\*.*?\*/)", r'(?s:""".*?""")|(?m:^\s*#.*$)', r"(?m:^\s*#.*$)"
COMMENTS = {".cpp": CPP, ".hpp": CPP, ".h": CPP, ".mjs": CPP, ".py": PYTHON, "": PYTHON, ".toml": HASH_SIGN, ".csv": HASH_SIGN,
            ".obj": HASH_SIGN}

WIDTH = 110

HEAD = """# Charts

Every chart of this project, in the order of the paper: from the scene to the force. Each stands with what it
shows, its command, its data and the page that discusses it. `scripts/charts --page` writes this page from
[scripts/gallery/charts.toml](../../scripts/gallery/charts.toml): change it there. Pictures of the scenes are
in the [gallery](../gallery.md).

```
scripts/charts                         # all on small grids, drawn into build/charts
scripts/charts --only models faults    # some of them
scripts/charts --only models --full    # measured as here, and written here
scripts/charts --draw-only             # draws this folder again from its tables
scripts/charts --list                  # names, and how long each takes
```

`scripts/check_charts` names each chart whose scenes or code have changed since it was measured. A chart that has not
been measured again since then names its commit.

Small grids take {small} with two processors of their own; a full one says its time beside its command.

All were measured on a shared virtual machine, two processors of an AMD EPYC, Debian 12: compare ratios within
a chart, not times between machines. Charts marked *timed* depend on a clock; the others come out the same to
the byte with the same build on the same machine.

"""


def read():
    with open(HERE / "charts.toml", "rb") as stream:
        return tomllib.load(stream)


def essence(file):
    """A file without comments and spaces; of a page its blocks of code."""
    text = file.read_text(errors="replace")
    if file.suffix == ".md":
        text = "".join(re.findall(r"(?ms)^```.*?^```", text))
    return "".join(re.sub(COMMENTS.get(file.suffix, "(?!)"), "", text).split()).encode()


def made_of(chart, root=ROOT):
    """{path: hash} of the scenes, sources and programs of a chart. Folders count as all their sources."""
    hashes = {}
    for path in chart.get("made_of", ()):
        found = hashlib.sha256()
        for file in sorted(file for top in root.glob(path) for file in (top.rglob("*") if top.is_dir() else (top,))):
            if file.is_file() and file.suffix in {".md", *COMMENTS}:
                found.update(file.relative_to(root).as_posix().encode() + b"\0" + essence(file) + b"\0")
        hashes[path] = found.hexdigest()[:12]
    return hashes


def noted():
    """{chart: {path: hash}} as they were when the charts were measured."""
    charts = {}
    for line in NOTED.read_text().splitlines():
        name, hash_of_path, path = line.split(maxsplit=2)
        charts.setdefault(name, {})[path] = hash_of_path
    return charts


def note(charts):
    """These charts are of the files as they are now."""
    table = noted() | {chart["name"]: made_of(chart) for chart in charts}
    known = {chart["name"] for chart in read()["chart"]}
    NOTED.write_text("".join(f"{name} {hash_of_path} {path}\n" for name, paths in sorted(table.items()) if name in known
                             for path, hash_of_path in sorted(paths.items())))


def inputs():
    return DATA


def small_words(charts, jobs=2):
    total_s = sum(chart["small_s"] / (1 if chart["timed"] else jobs) for chart in charts)
    return f"about {max(1, round(total_s / 60))} min"


def anchor(heading):
    """As GitHub and others make it."""
    return "".join(letter for letter in heading.lower().replace(" ", "-") if letter.isalnum() or letter == "-")


def paragraph(text):
    return [textwrap.fill(text, WIDTH, break_long_words=False, break_on_hyphens=False), ""]


def page_of_chart(chart):
    lines = [f"### {chart['title']}", "", *paragraph(chart["shows"])]
    if "stale_since" in chart:
        lines += paragraph(f"**Measured on commit {chart['stale_since']}**; its scenes or code have changed since.")
    for picture in chart["pictures"]:
        if "shows" in picture:
            lines += paragraph(picture["shows"])
        lines += [f"![{chart['title']}]({picture['file']})", ""]
    programs = [program.rpartition("/")[2].split()[0] for program in chart["measure"] + [chart.get("draw", "")]
                if program]
    how = (f"`scripts/charts --only {chart['name']} --full` ({chart['full']}"
           f"{', timed' if chart['timed'] else ''}{', needs the real inputs' if chart.get('inputs') else ''}; "
           f"{', '.join(f'`{name}`' for name in dict.fromkeys(programs))})")
    data = ", ".join(f"[{name}]({name})" for name in chart.get("data", ())) or "drawn as it is measured"
    pages = dict.fromkeys([chart["page"]] + [picture.get("page", chart["page"]) for picture in chart["pictures"]])
    links = ", ".join(f"[{page.removeprefix('../')}](../{page})" for page in pages)
    return lines + paragraph(f"Command: {how}. Data: {data}. {'Page' if len(pages) == 1 else 'Pages'}: {links}.")


def page(table):
    """docs/charts/README.md."""
    charts = table["chart"]
    lines = [HEAD.replace("{small}", small_words(charts)).rstrip(), ""]
    sections = {name: [chart for chart in charts if chart["section"] == name] for name in table["sections"]}
    sections = {name: some for name, some in sections.items() if some}
    for name, some in sections.items():
        lines += [f"* [{name}](#{anchor(name)})"]
        lines += [f"  * [{chart['title']}](#{anchor(chart['title'])})" for chart in some]
    lines.append("")
    for name, some in sections.items():
        lines += [f"## {name}", "", *paragraph(table["sections"][name])]
        for chart in some:
            lines += page_of_chart(chart)
    return "\n".join(lines).rstrip() + "\n"
