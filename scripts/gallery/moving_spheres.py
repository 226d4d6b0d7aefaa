#!/usr/bin/python3
"""Publishes spheres that all move at each step, so that no snapshot tells less than all of them."""
import argparse

import numpy

import recording  # for the package's path
import stillgrid

SWING_M = 0.002


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--session", required=True)
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--rate", type=float, required=True, help="Hz")
    parser.add_argument("--duration", type=float, required=True, help="s")
    arguments = parser.parse_args()
    random = numpy.random.default_rng(arguments.count)
    centres_m = random.uniform(-0.1, 0.1, (arguments.count, 3))
    pulses_rad_s = random.uniform(1.0, 9.0, (arguments.count, 1))
    scene = stillgrid.Scene(1.0 / arguments.rate, arguments.count, [stillgrid.Material(500.0)])
    with stillgrid.Publisher(scene, arguments.session) as publisher:
        publisher.set_shapes(numpy.full(arguments.count, 0.003))
        for time_s in publisher.steps(arguments.duration):
            angles = pulses_rad_s * time_s
            swing_m, velocity_m_s = SWING_M * numpy.sin(angles), SWING_M * pulses_rad_s * numpy.cos(angles)
            publisher.set_spheres(centres_m + swing_m, numpy.repeat(velocity_m_s, 3, axis=1))
            publisher.publish()


if __name__ == "__main__":
    main()
