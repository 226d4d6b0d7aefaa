#!/usr/bin/python3
"""A scene too heavy for its rate: steps run late, and each is published. Gates on counts: a shared machine
stalls now and then."""
import os
import signal
import time
import unittest

import daemons
from daemons import DONE, NOT_CONVERGED

RATE_HZ = 33.0
MATERIAL = """format = 2
[simulation]
rate_hz = {rate_hz}
sleeping = false
[[material]]
name = "stiff"
contact_stiffness_N_per_m = 1e6
contact_damping_N_s_per_m = 5.0
friction = 0.5
[[body]]
name = "floor"
kind = "plane"
normal = [0.0, 0.0, 1.0]
material = "stiff"
"""
BLOCK = """[[body]]
name = "block {number}"
kind = "rigid_box"
size_m = [0.03, 0.03, 0.02]
position_m = [{x_m}, {y_m}, {z_m}]
mass_kg = 0.02
velocity_m_s = [0.0, 0.0, -1.0]
angular_velocity_rad_s = [3.0, {number}.0, 1.0]
spheres = {{ spacing_m = 0.01, radius_m = 0.005 }}
material = "stiff"
"""


class BudgetTest(daemons.SessionTest):
    def rain_of_blocks(self):
        """They fall into a heap, on contacts of k h^2 / m = 46000: hard for any solver."""
        blocks = (BLOCK.format(number=i, x_m=0.035 * (i % 3), y_m=0.035 * (i // 3 % 2),
                               z_m=0.05 + 0.04 * (i // 6)) for i in range(18))
        return self.write("rain.toml", MATERIAL.format(rate_hz=RATE_HZ) + "".join(blocks))

    def test_a_scene_too_heavy_for_its_rate_runs_late_and_publishes_each_step(self):
        scene = self.rain_of_blocks()
        unbound, bound = self.folder / "unbound.json", self.folder / "bound.json"
        offline = self.start(daemons.BUILD / "bin" / "sim_server", "--scene", scene, "--offline",
                             "--duration", 0.4, "--report", unbound)
        self.assertIn(offline.wait(60.0), (DONE, NOT_CONVERGED), offline.lines())
        sim_server = self.sim_server(scene, "--duration", 3, "--report", bound)
        self.assertIn(sim_server.wait(30.0), (DONE, NOT_CONVERGED), sim_server.lines())

        # Without a clock most steps take longer than their period.
        self.assertGreater(daemons.read_report(unbound)["step_ms"]["p50"], 1e3 / RATE_HZ)
        report = daemons.read_report(bound)
        # A step makes up for what is missing, until its budget ends it.
        self.assertGreater(report["solver"]["out_of_budget"], 0)
        self.assertEqual(report["snapshots"], report["steps"] + 1)
        self.assertIn("out of time or iterations", "".join(sim_server.lines()))

    def test_what_other_programs_take_of_the_processor_cuts_no_step_short(self):
        report = self.folder / "sim.json"
        for _ in range(2 * os.cpu_count()):
            self.start("sh", "-c", "while :; do :; done")
        hand = f"phantom:path={daemons.SCENES / 'sewn_ball.hand.csv'}"  # a light scene: most steps are of one tick
        sim_server = self.sim_server("sewn_ball", "--duration", 3, "--report", report)
        self.haptic_server(hand, "--duration", 3)
        self.assertEqual(sim_server.wait(30.0), DONE, sim_server.lines())
        figures = daemons.read_report(report)
        self.assertGreater(figures["steps"], 300)
        self.assertLess(figures["solver"]["out_of_budget"], 0.02 * figures["steps"], figures)

    def test_simulated_time_that_falls_behind_is_a_line(self):
        report = self.folder / "sim.json"
        sim_server = self.sim_server("wall", "--rate", 1000, "--duration", 2.5, "--report", report)
        time.sleep(0.3)
        sim_server.signal(signal.SIGSTOP)
        time.sleep(2.0)
        sim_server.signal(signal.SIGCONT)
        self.assertEqual(sim_server.wait(30.0), DONE, sim_server.lines())
        self.assertGreater(daemons.read_report(report)["late_steps"], 1900)
        self.assertIn("deadlines passed without a step", sim_server.lines()[-1])


if __name__ == "__main__":
    daemons.main()
