#!/usr/bin/python3
"""Draws the Inverse3's axes as its user sees them, sitting before it: haply_axes.svg."""
import argparse
import pathlib

ORIGIN = (150, 150)
AXES = (("x", "right", (105, 0), "#c0392b"), ("y", "forward, away from you", (58, -48), "#27803b"),
        ("z", "up", (0, -105), "#2457a6"))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--charts", type=pathlib.Path, required=True, metavar="FOLDER")
    parser.add_argument("pictures", nargs="*", help="there is one")
    arguments = parser.parse_args()
    lines = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 420 230" width="420" height="230" '
             'font-family="sans-serif" font-size="13">',
             '<rect width="420" height="230" fill="white"/>',
             '<path d="M70 180 L250 180 L310 130 L130 130 Z" fill="#eeeeee" stroke="#999999"/>',
             '<text x="20" y="212">you sit here; the plate stands on the desk before you</text>']
    x, y = ORIGIN
    for name, meaning, (dx, dy), colour in AXES:
        lines.append(f'<line x1="{x}" y1="{y}" x2="{x + dx}" y2="{y + dy}" stroke="{colour}" stroke-width="3"/>')
        lines.append(f'<circle cx="{x + dx}" cy="{y + dy}" r="4" fill="{colour}"/>')
        lines.append(f'<text x="{x + dx + 8}" y="{y + dy + 4}" fill="{colour}">{name}: {meaning}</text>')
    lines.append('</svg>')
    (arguments.charts / "haply_axes.svg").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
