#!/usr/bin/python3
"""Makes the mesh of the scenes `organ` and `laparoscopy`: a kidney-shaped closed surface, 50 mm long, as an OBJ file.

The same file on every run: sim_server/scene/scenes/organ.obj is what it writes.
"""
import argparse
import math
import pathlib

LENGTH_M, WIDTH_M, HEIGHT_M = 0.05, 0.032, 0.026
BEND_M = 0.008  # the ends' way towards +y
RINGS, SEGMENTS = 16, 24


def place(direction):
    """The point of the surface in a direction from the centre."""
    x, y, z = direction
    swell = 1.0 + 0.12 * x - 0.06 * math.cos(3.0 * x)  # one end thicker than the other
    return (0.5 * LENGTH_M * x, 0.5 * WIDTH_M * y * swell + BEND_M * (x * x - 0.5),
            0.5 * HEIGHT_M * z * swell)


def vertices():
    """A pole, rings of points, the other pole."""
    yield place((-1.0, 0.0, 0.0))
    for ring in range(1, RINGS):
        polar = math.pi * ring / RINGS
        for segment in range(SEGMENTS):
            turn = 2.0 * math.pi * segment / SEGMENTS
            yield place((-math.cos(polar), math.sin(polar) * math.cos(turn),
                         math.sin(polar) * math.sin(turn)))
    yield place((1.0, 0.0, 0.0))


def triangles():
    """Corners counted from 1, counter-clockwise seen from outside."""
    def at(ring, segment):
        return 2 + (ring - 1) * SEGMENTS + segment % SEGMENTS

    last = 2 + (RINGS - 1) * SEGMENTS
    for segment in range(SEGMENTS):
        yield 1, at(1, segment + 1), at(1, segment)
        yield last, at(RINGS - 1, segment), at(RINGS - 1, segment + 1)
        for ring in range(1, RINGS - 1):
            yield at(ring, segment), at(ring, segment + 1), at(ring + 1, segment)
            yield at(ring, segment + 1), at(ring + 1, segment + 1), at(ring + 1, segment)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=pathlib.Path, metavar="OUT.obj")
    lines = ["# Written by scripts/make_organ.py; metres."]
    lines += ["v {:.6f} {:.6f} {:.6f}".format(*vertex) for vertex in vertices()]
    lines += ["f {} {} {}".format(*corners) for corners in triangles()]
    parser.parse_args().out.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
