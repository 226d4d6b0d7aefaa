"""What every script that draws shares: its options, its style, and how a picture is written."""
import argparse
import os
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import matplotlib.ticker  # for those who import this

CHARTS = pathlib.Path(__file__).resolve().parents[2] / "docs/charts"
STYLE = {"axes.spines.top": False, "axes.spines.right": False, "font.size": 9.5}


def show_plain_numbers(axis):
    """1, 2, 5, 10 and so on, for logarithmic axes that span little more than a decade."""
    axis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(matplotlib.ticker.NullFormatter())


def label_logarithmic(axes, title, label_x, label_y):
    """Axes over decades, with their title and labels."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(label_x)
    axes.set_ylabel(label_y)
    axes.set_title(title, loc="left", fontsize=10.5, fontweight="bold")
    axes.grid(True, which="major", color="0.92")


def save(figure, file, dpi=110):
    """Whole or not at all."""
    part = file.with_name(f"{file.stem}.part.png")
    try:
        figure.savefig(part, dpi=dpi, facecolor="white")
        os.replace(part, file)
    finally:
        part.unlink(missing_ok=True)
    plt.close(figure)


def draw_charts(description, pictures, dpi=110, flag=(None, None)):
    """The whole of a script that draws. Pictures: by name, functions that make a figure of the folder of
    tables. Returns that folder, and whether the script's own flag (its name and help) was given."""
    parser = argparse.ArgumentParser(description=description,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pictures", nargs="*", metavar="PICTURE",
                        help=f"some of {', '.join(pictures)}; default: all")
    parser.add_argument("--charts", type=pathlib.Path, default=CHARTS, metavar="FOLDER",
                        help="where tables are read and pictures written; default: docs/charts")
    if flag[0]:
        parser.add_argument(flag[0], dest="flag", action="store_true", help=flag[1])
    arguments = parser.parse_args()
    for name in set(arguments.pictures) - set(pictures):
        parser.error(f"PICTURE: value {name}: expected some of {', '.join(pictures)}")
    plt.rcParams.update(STYLE)
    try:
        for name in arguments.pictures or pictures:
            save(pictures[name](arguments.charts), arguments.charts / f"{name}.png", dpi)
    except (OSError, ValueError, KeyError, IndexError) as error:
        sys.exit(f"{parser.prog}: {arguments.charts}: {type(error).__name__}: {error}")
    return arguments.charts, bool(flag[0]) and arguments.flag
