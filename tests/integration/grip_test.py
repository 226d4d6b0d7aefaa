#!/usr/bin/python3
"""A fork of two spheres holds, lifts and turns a block by friction alone."""
import csv

import numpy

import daemons

SCENE = """format = 2
[tool]
{contact}spheres = [{{ position_m = [-0.029, 0.0, 0.0], radius_m = 0.01 }},
           {{ position_m = [0.029, 0.0, 0.0], radius_m = 0.01 }}]
[device]
position_m = [0.0, 0.0, 0.1]
[[material]]
name = "pad"
contact_stiffness_N_per_m = 2000.0
contact_damping_N_s_per_m = 2.0
friction = 0.7
[[body]]
name = "block"
kind = "rigid_box"
size_m = [0.04, 0.04, 0.04]
position_m = [0.0, 0.0, 0.1]
mass_kg = 0.045
material = "pad"
"""
SETTLE_S, PERIOD_S, SAMPLE_S = 1.0, 60.0, 0.005
MOST_CREEP_M, MOST_STEP_N = 2e-5, 1e-3  # it finds its seat in the first minute


def hand(duration_s):
    """Rests for a second, lifts by 50 mm, sways, yaws by 30 and rolls by 20 degrees. Returns each minute."""
    time_s = SAMPLE_S * numpy.arange(round((duration_s + 0.1) / SAMPLE_S))
    turn = 2.0 * numpy.pi * numpy.maximum(0.0, time_s - SETTLE_S) / PERIOD_S
    half_yaw = numpy.radians(15.0) * numpy.sin(2.0 * turn)
    half_roll = numpy.radians(10.0) * numpy.sin(turn)
    columns = {"time_s": time_s, "x_m": 0.02 * numpy.sin(4.0 * turn), "y_m": 0.01 * numpy.sin(5.0 * turn),
               "z_m": 0.025 * (1.0 - numpy.cos(3.0 * turn)),
               "qx": numpy.cos(half_yaw) * numpy.sin(half_roll), "qy": numpy.sin(half_yaw) * numpy.sin(half_roll),
               "qz": numpy.sin(half_yaw) * numpy.cos(half_roll), "qw": numpy.cos(half_yaw) * numpy.cos(half_roll)}
    rows = numpy.stack(list(columns.values()), axis=1)
    return ",".join(columns) + "\n" + "".join(",".join(f"{value:.9f}" for value in row) + "\n" for row in rows)


class Grip(daemons.SessionTest):
    def held(self, duration_s, contact=""):
        """The block's place at the end, m, and the recording."""
        scene = self.write("grip.toml", SCENE.format(contact=contact))
        path, state = self.write("hand.csv", hand(duration_s)), self.folder / "state.csv"
        recording = self.run_lockstep(scene, f"replay:file={path}", duration_s, ("--final-state", state),
                                      wait_s=daemons.LEAST_WAIT_S + duration_s)
        with open(state) as lines:
            block = next(csv.DictReader(lines))
        return numpy.array([float(block[f"{axis}_m"]) for axis in "xyz"]), daemons.read_recording(recording)

    def check_hold(self, minutes):
        before_m, _ = self.held(SETTLE_S)
        after_m, recording = self.held(SETTLE_S + minutes * PERIOD_S)
        self.assertLess(numpy.linalg.norm(after_m - before_m), MOST_CREEP_M)
        moving = recording["time_s"] > SETTLE_S + 1.0
        force_N = daemons.vectors(recording, "f", "N")[moving]
        self.assertLess(numpy.linalg.norm(numpy.diff(force_N, axis=0), axis=1).max(), MOST_STEP_N)


class GripTest(Grip):
    def test_a_block_is_held_lifted_and_turned_for_a_minute_without_creep_or_chatter(self):
        self.check_hold(1)

    def test_by_the_sum_over_spheres_friction_is_viscous_and_the_block_slips(self):
        before_m, _ = self.held(SETTLE_S)
        after_m, _ = self.held(SETTLE_S, 'contact = "penalty"\n')
        self.assertLess(after_m[2], before_m[2] - 0.001)


class TenMinutesTest(Grip):
    def test_a_block_is_held_lifted_and_turned_for_ten_minutes_without_creep_or_chatter(self):
        self.check_hold(10)


if __name__ == "__main__":
    daemons.main()
