#!/usr/bin/python3
"""A bed of balls on springs, simulated in numpy at 50 Hz and felt at 1 kHz (docs/python.md)."""
import numpy
import stillgrid

SIDE, SPACING_m, RADIUS_m, PERIOD_s = 9, 0.012, 0.010, 0.02
MASS_kg, DAMPING_N_s_per_m = 0.02, 1.0
SPRINGS_N_per_m = numpy.array([400.0, 400.0, 100.0])  # along x, y, z
COUNT = SIDE * SIDE
SCENE = stillgrid.Scene(PERIOD_s, COUNT, [stillgrid.Material(500.0, 1.0, friction=0.3)], predicts=True)


def simulate(publisher):
    bodies = numpy.arange(COUNT)
    row, column = numpy.divmod(bodies, SIDE)
    rest_m = SPACING_m * numpy.column_stack([row - SIDE // 2, column - SIDE // 2, 0 * row])
    # An implicit step, and so how a ball gives way over it, its springs included.
    inertia_kg = MASS_kg + PERIOD_s * DAMPING_N_s_per_m + PERIOD_s**2 * SPRINGS_N_per_m
    inverse_inertias = numpy.zeros((COUNT, 6, 6))
    inverse_inertias[:, :3, :3] = numpy.diag(1 / inertia_kg)

    positions_m, velocities_m_s = rest_m, numpy.zeros((COUNT, 3))
    publisher.set_shapes(numpy.full(COUNT, RADIUS_m), bodies=bodies)
    for _ in publisher.steps():
        forces_N = SPRINGS_N_per_m * (rest_m - positions_m)
        velocities_m_s = (MASS_kg * velocities_m_s + PERIOD_s * forces_N) / inertia_kg
        publisher.set_spheres(positions_m, velocities_m_s)
        publisher.set_responses(bodies, positions_m, inverse_inertias)
        pushes = publisher.pushes()
        velocities_m_s[pushes.body] += PERIOD_s * pushes.force_N / inertia_kg
        publisher.set_predicted(velocities_m_s)
        publisher.publish()
        positions_m = positions_m + PERIOD_s * velocities_m_s


if __name__ == "__main__":
    with stillgrid.Session(device="phantom:hand=light,path=press,depth_m=0.025", duration_s=5) as session:
        with session.publish(SCENE) as publisher:
            simulate(publisher)
    print(f"felt {session.report['ticks']} ticks, {session.report['force_N']['max']:.2f} N at most")
