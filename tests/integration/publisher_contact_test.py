#!/usr/bin/python3
"""Bodies of a publisher are solid for a hand: whatever covers them, held by friction, as they come and go."""
import numpy

import daemons
import python_test  # for the library's place
import stillgrid

RADIUS_M, STIFFNESS_N_PER_M = 0.02, 500.0
TOOL_M = 0.005  # the default tool's radius


class PublisherContact(daemons.SessionTest):
    def path(self, time_s, x_m, z_m):
        zeros = numpy.zeros_like(time_s)
        rows = numpy.stack((time_s, x_m + zeros, zeros, z_m + zeros, zeros, zeros, zeros, zeros + 1.0), axis=1)
        lines = "".join(",".join(f"{value:.9f}" for value in row) + "\n" for row in rows)
        return "replay:file=" + str(self.write("hand.csv", "time_s,x_m,y_m,z_m,qx,qy,qz,qw\n" + lines))

    def press(self, depth_m, duration_s, height_m, speed_m_s=0.0):
        """Down from 5 mm above in 0.1 s, then along x."""
        time_s = 0.002 * numpy.arange(round(duration_s / 0.002) + 2)
        down = numpy.minimum(1.0, time_s / 0.1)
        return self.path(time_s, speed_m_s * numpy.maximum(0.0, time_s - 0.1),
                         height_m + TOOL_M + 0.005 - (depth_m + 0.005) * down)


class ComesAndGoesTest(PublisherContact):
    GOES_S, COMES_S, END_S = 0.5, 0.8, 1.2

    def felt(self, period_s, transition, gives_inertia, is_there, number=lambda step: 0):
        """A ball that is_there in some steps, as sphere `number` of two. The other one is far."""
        scene = stillgrid.Scene(period_s, 2, [stillgrid.Material(STIFFNESS_N_PER_M)], gives_inertia=gives_inertia)
        device = self.press(0.003, self.END_S, RADIUS_M)
        arguments = () if transition is None else ("--transition", transition)
        with stillgrid.Session(device=device, lockstep=True, duration_s=self.END_S,
                               haptic_arguments=arguments) as session:
            with session.publish(scene) as publisher:
                publisher.set_shapes([RADIUS_M])
                for step, _ in enumerate(publisher.steps()):
                    balls = [(numpy.zeros(3), 7)] if is_there(step) else []
                    balls.insert(0 if number(step) else len(balls), (numpy.full(3, 0.3), 3))
                    publisher.set_shapes([RADIUS_M] * len(balls), bodies=[body for _, body in balls])
                    publisher.set_spheres([place_m for place_m, _ in balls])
                    if gives_inertia:
                        bodies = [body for _, body in balls]
                        publisher.set_responses(bodies, [place_m for place_m, _ in balls],
                                                numpy.zeros((len(balls), 6)), numpy.zeros((len(balls), 6, 6)))
                    publisher.publish()
        return session

    def each(self):
        for period_s in (0.001, 0.02):
            for transition in (None, "linear", "hold"):
                for gives_inertia in (False, True):
                    with self.subTest(period_s=period_s, transition=transition, gives_inertia=gives_inertia):
                        yield period_s, transition, gives_inertia

    def assert_even(self, session):
        still = session.recording.time_s[1:] > 0.11
        steps_N = numpy.linalg.norm(numpy.diff(session.recording.rendered_force_N, axis=0), axis=1)
        self.assertLess(steps_N[still].max(), 0.05)
        self.assertLess(session.report["switch_jump_N"]["max"], 0.05)

    def test_a_touched_body_that_goes_or_comes_is_felt_evenly(self):
        for period_s, *how in self.each():
            session = self.felt(period_s, *how, lambda step: not self.GOES_S <= step * period_s < self.COMES_S)
            force_N = session.recording.rendered_force_N[:, 2]
            before, gone, end = (force_N[round(1000.0 * at_s)] for at_s in
                                 (self.GOES_S - 0.03, self.COMES_S - 0.05, self.END_S - 0.01))
            self.assertAlmostEqual(before, STIFFNESS_N_PER_M * 0.003, 3)
            self.assertEqual(gone, 0.0)
            self.assertAlmostEqual(end, before, 3)
            self.assert_even(session)

    def test_a_touched_body_that_is_gone_for_a_step_now_and_then_is_felt_evenly(self):
        for period_s, *how in self.each():
            self.assert_even(self.felt(period_s, *how, lambda step: step * period_s < self.GOES_S or step % 3))

    def test_other_numbers_of_the_spheres_are_not_felt(self):
        for period_s, *how in self.each():
            session = self.felt(period_s, *how, lambda step: True, lambda step: step * period_s > self.GOES_S)
            pressed = session.recording.time_s > 0.11
            force_N = session.recording.rendered_force_N[pressed, 2]
            self.assertLess(abs(force_N - STIFFNESS_N_PER_M * 0.003).max(), 0.02)


class OtherSurfacesTest(PublisherContact):
    def test_a_body_that_a_copy_moves_takes_nothing_from_a_plane(self):
        """A ball leans on the tool's side while it presses on a plane."""
        scene = stillgrid.Scene(0.02, 1, [stillgrid.Material(STIFFNESS_N_PER_M)], gives_inertia=True,
                                planes=[stillgrid.Plane((0.0, 0.0, 1.0), 0.0, 0, 5)])
        with stillgrid.Session(device=self.press(0.003, 1.0, 0.0), lockstep=True, duration_s=1.0) as session, \
                session.publish(scene) as publisher:
            publisher.set_shapes([RADIUS_M])
            for step, _ in enumerate(publisher.steps()):
                if step > 0:
                    publisher.pushes()
                near_m = min(0.005, 0.005 * max(0.0, step * 0.02 - 0.3))
                place_m = [RADIUS_M + TOOL_M + 0.002 - near_m, 0.0, 0.002]
                publisher.set_spheres([place_m])
                publisher.set_responses([0], [place_m], [[0.0] * 6], numpy.zeros((1, 6, 6)))
                publisher.publish()
        force_N = session.recording.rendered_force_N[session.recording.time_s > 0.12]
        self.assertLess(force_N[-1, 0], -0.2)
        self.assertLess(abs(force_N[:, 2] - STIFFNESS_N_PER_M * 0.003).max(), 0.05)
        self.assertLess(numpy.linalg.norm(numpy.diff(force_N, axis=0), axis=1).max(), 0.05)


class CoverTest(PublisherContact):
    def test_a_plate_is_felt_as_stiffness_times_depth_however_dense_its_cover(self):
        depth_m, small_m = 0.004, 0.003
        for spacing_m in (0.003, 0.0015, 0.0006):
            places_m = numpy.arange(-0.012, 0.02, spacing_m)
            x_m, y_m = numpy.meshgrid(places_m, places_m)
            plate_m = numpy.stack((x_m.ravel(), y_m.ravel(), numpy.full(x_m.size, -small_m)), axis=1)
            scene = stillgrid.Scene(0.02, len(plate_m), [stillgrid.Material(STIFFNESS_N_PER_M)])
            pushed_N = []
            with stillgrid.Session(device=self.press(depth_m, 0.6, 0.0, 0.01), lockstep=True,
                                   duration_s=0.6) as session, session.publish(scene) as publisher:
                publisher.set_shapes([small_m] * len(plate_m))
                for _ in publisher.steps():
                    pushed_N.append(publisher.pushes().force_N.sum(axis=0)[2] if pushed_N else 0.0)
                    publisher.set_spheres(plate_m)
                    publisher.publish()
            right_N = STIFFNESS_N_PER_M * depth_m
            with self.subTest(spacing_m=spacing_m):
                pressed = session.recording.time_s > 0.12
                off_N = numpy.linalg.norm(session.recording.rendered_force_N[pressed] - [0.0, 0.0, right_N], axis=1)
                self.assertLess(off_N.max(), 0.05 * right_N)
                self.assertLess(abs(numpy.array(pushed_N[8:]) + right_N).max(), 0.05 * right_N)


class GripTest(PublisherContact):
    MASS_KG, STEP_S, STEPS, END_S = 0.045, 0.001, 10, 9.0

    def ball(self, publisher):
        """A free ball on a floor: its height at each publication."""
        position_m, velocity = numpy.zeros(3), numpy.zeros(6)
        inverse = numpy.diag([1.0 / self.MASS_KG] * 3 + [2.5 / (self.MASS_KG * RADIUS_M**2)] * 3)
        heights_m = []

        def show():
            publisher.set_spheres([position_m], [velocity[:3]])
            publisher.set_responses([0], [position_m], [velocity], [inverse])

        publisher.set_shapes([RADIUS_M])
        show()
        for _ in publisher.steps():
            for _ in range(self.STEPS):
                wrench = numpy.array([0.0, 0.0, -9.81 * self.MASS_KG, 0.0, 0.0, 0.0])
                for push in publisher.pushes(self.STEP_S):
                    lever_m = push.point_m - position_m
                    wrench += numpy.concatenate((push.force_N, push.torque_N_m + numpy.cross(lever_m, push.force_N)))
                if position_m[2] < 0.0:
                    wrench[2] += -5000.0 * position_m[2] - 10.0 * velocity[2]
                velocity += self.STEP_S * inverse @ wrench
                position_m += self.STEP_S * velocity[:3]
                show()
            heights_m.append(position_m[2])
            publisher.publish()
        return numpy.array(heights_m)

    def test_a_ball_between_two_spheres_of_the_tool_is_lifted_and_held_without_creep(self):
        out_m, up_m = RADIUS_M + TOOL_M - 0.001, 0.02
        hand = stillgrid.Hand(tool_m=[(-out_m, 0.0, 0.0, TOOL_M), (out_m, 0.0, 0.0, TOOL_M)])
        scene = stillgrid.Scene(self.STEP_S * self.STEPS, 1, [stillgrid.Material(2000.0, 2.0, 0.7)],
                                gives_inertia=True, hands=[hand])
        time_s = 0.01 * numpy.arange(round(100.0 * self.END_S) + 2)
        device = self.path(time_s, 0.0, 0.03 * numpy.clip(1.0 - time_s, 0.0, 1.0) +
                           up_m * numpy.clip(0.5 * (time_s - 1.5), 0.0, 1.0))
        with stillgrid.Session(device=device, lockstep=True, duration_s=self.END_S) as session, \
                session.publish(scene) as publisher:
            heights_m = self.ball(publisher)
        held_m = heights_m[round(100.0 * 4.5):]
        self.assertGreater(held_m[0], up_m - 0.002)  # the prongs stick above its middle as they come down
        minutes = self.STEP_S * self.STEPS * len(held_m) / 60.0
        self.assertLess(abs(held_m[-1] - held_m[0]) / minutes, 1e-4)  # m a minute
        force_N = session.recording.rendered_force_N[round(1000.0 * 4.5):]
        self.assertAlmostEqual(force_N[:, 2].mean(), -9.81 * self.MASS_KG, delta=0.005)
        self.assertLess(numpy.linalg.norm(force_N - force_N.mean(axis=0), axis=1).max(), 0.005)
