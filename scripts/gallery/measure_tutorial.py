#!/usr/bin/python3
"""Draws the pictures of a page of docs/tutorials by the page's own commands, in virtual time: its NAME.png becomes
docs/charts/tutorial_NAME.png."""
import pathlib
import shutil
import sys
import tempfile

from measuring import ROOT, fail, parser_of

sys.path.append(str(ROOT / "scripts/pages"))
import tutorials


def main():
    parser = parser_of(__doc__, "the same: it is small")
    parser.add_argument("page", choices=tutorials.names(), metavar="PAGE", help=", ".join(tutorials.names()))
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        status, printed = tutorials.run(arguments.page, folder, arguments.build)
        if status:
            fail(f"docs/tutorials/{arguments.page}.md: {printed}")
        for name in tutorials.pictures(arguments.page):
            shutil.copyfile(tutorials.picture_of(folder, name), arguments.charts / f"tutorial_{name}.png")


if __name__ == "__main__":
    main()
