#!/usr/bin/python3
"""Our forces against those that others measured at the same places; both daemons, in lockstep."""
import itertools
import unittest

import numpy

import daemons
import recorded_forces  # of scripts/gallery, by daemons

LEAST_COSINES = {"field": 0.7, "spheres": 0.85, "penalty": 0.9}


class RecordedForcesTest(daemons.SessionTest):
    def replay(self, scene, device, duration_s):
        return self.run_lockstep(self.write("recorded.toml", scene), device, duration_s)

    def test_a_wall_fitted_to_half_of_a_springs_recording_predicts_the_other_half_as_well_as_any_line(self):
        if not recorded_forces.SPRING.exists():
            self.skipTest(f"skipped: {recorded_forces.SPRING} is absent")
        spring = recorded_forces.Spring()
        file = self.replay(spring.scene(), spring.device(), spring.time_s[-1])
        time_s, place_m, measured_N, ours_N = spring.compare(file)
        second = time_s >= spring.half_s
        rms_N = numpy.sqrt(((ours_N - measured_N)[second] ** 2).mean())
        # The line that fits the second half best, and what is left of it: friction, play, noise.
        best = numpy.polyfit(place_m[second], measured_N[second], 1)
        least_N = numpy.sqrt(((numpy.polyval(best, place_m[second]) - measured_N[second]) ** 2).mean())
        self.assertLess(rms_N, 2.5 * least_N)
        # A wall a tenth stiffer or softer, or a millimetre off, would not do.
        for stiffness_N_per_m, rest_m in ((1.1, 0.0), (0.9, 0.0), (1.0, 1e-3), (1.0, -1e-3)):
            wrong_N = stiffness_N_per_m * spring.stiffness_N_per_m * (place_m - spring.rest_m - rest_m)
            wrong_rms_N = numpy.sqrt(((wrong_N - measured_N)[second] ** 2).mean())
            self.assertGreater(wrong_rms_N, 2.5 * least_N)

    def test_on_a_contour_our_force_goes_with_the_hands(self):
        if not recorded_forces.CONTOUR_MESH.exists():
            self.skipTest(f"skipped: {recorded_forces.CONTOUR_MESH} is absent")
        # All eight: scripts/gallery/measure_recorded_forces.py. The contact is on an edge. The nearest face's normal
        # has a cosine of 0.7 to 0.82 with the recorded force, and what rounds the edge has more.
        for name, (contact, least) in itertools.product(recorded_forces.DEMONSTRATIONS[:2], LEAST_COSINES.items()):
            with self.subTest(name, contact=contact):
                file = self.replay(recorded_forces.contour_scene(contact), recorded_forces.contour_device(name),
                                   recorded_forces.contour_duration_s(name))
                share, cosine = recorded_forces.compare_contour(name, file)
                self.assertGreater(share, 0.95)
                self.assertGreater(cosine, least)


if __name__ == "__main__":
    daemons.main()
