#!/usr/bin/python3
"""Writes a picture (PNG) again with a palette of as many colours as fit into so many bytes, 256 at most, not
dithered: for pictures of flat surfaces, on which that is not seen."""
import argparse
import io
import pathlib
import sys

import PIL.Image

COLOURS = (256, 192, 128, 96, 64, 48, 32)


def shrink(picture, max_bytes):
    for colours in COLOURS:
        stream = io.BytesIO()
        picture.convert("RGB").quantize(colours, dither=PIL.Image.Dither.NONE).save(stream, "PNG", optimize=True)
        if stream.tell() <= max_bytes:
            return stream.getvalue()
    return None


def main():
    parser = argparse.ArgumentParser(prog="shrink_png", description=__doc__)
    parser.add_argument("picture", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--max-bytes", type=int, default=150_000, metavar="N", help="default: 150000")
    arguments = parser.parse_args()
    try:
        with PIL.Image.open(arguments.picture) as picture:
            small = shrink(picture, arguments.max_bytes)
    except (OSError, PIL.UnidentifiedImageError) as error:
        sys.exit(f"shrink_png: {arguments.picture}: {error}")
    if small is None:
        sys.exit(f"shrink_png: {arguments.picture}: expected a picture that fits into {arguments.max_bytes} bytes "
                 f"with {COLOURS[-1]} colours")
    part = arguments.out.with_name(arguments.out.name + ".part")
    part.write_bytes(small)
    part.rename(arguments.out)


if __name__ == "__main__":
    main()
