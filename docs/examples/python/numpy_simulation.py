#!/usr/bin/python3
"""A bed of pins on springs, simulated in numpy, shown at 50 Hz and felt at 1 kHz (docs/python.md)."""
import numpy
import stillgrid

SIDE, SPACING_m, RADIUS_m, PERIOD_s, STEP_s = 9, 0.012, 0.010, 0.02, 0.001
MASS_kg, DAMPING_N_s_per_m, SPRING_N_per_m = 0.02, 1.0, 100.0
COUNT = SIDE * SIDE
SCENE = stillgrid.Scene(PERIOD_s, COUNT, [stillgrid.Material(500.0, friction=0.3)], gives_inertia=True)


def simulate(publisher):
    bodies = numpy.arange(COUNT)
    row, column = numpy.divmod(bodies, SIDE)
    positions_m = SPACING_m * numpy.column_stack([row - SIDE // 2, column - SIDE // 2, 0 * row])
    velocities_m_s = numpy.zeros((COUNT, 3))
    inverse_inertias = numpy.zeros((COUNT, 6, 6))
    inverse_inertias[:, 2, 2] = 1 / MASS_kg  # up and down alone
    twists = numpy.zeros((COUNT, 6))

    def show():
        publisher.set_spheres(positions_m, velocities_m_s)
        twists[:, :3] = velocities_m_s
        publisher.set_responses(bodies, positions_m, twists, inverse_inertias)

    publisher.set_shapes(numpy.full(COUNT, RADIUS_m), bodies=bodies)
    show()
    for _ in publisher.steps():
        for _ in range(round(PERIOD_s / STEP_s)):
            pushes = publisher.pushes(STEP_s)
            forces_N = -SPRING_N_per_m * positions_m[:, 2]
            numpy.add.at(forces_N, pushes.body, pushes.force_N[:, 2])
            # An implicit step.
            inertia_kg = MASS_kg + STEP_s * DAMPING_N_s_per_m + STEP_s**2 * SPRING_N_per_m
            velocities_m_s[:, 2] = (MASS_kg * velocities_m_s[:, 2] + STEP_s * forces_N) / inertia_kg
            positions_m += STEP_s * velocities_m_s
            show()
        publisher.publish()


if __name__ == "__main__":
    with stillgrid.Session(device="phantom:hand=light,path=press,depth_m=0.03", duration_s=5) as session:
        with session.publish(SCENE) as publisher:
            simulate(publisher)
    print(f"felt {session.report['ticks']} ticks, {session.report['force_N']['max']:.2f} N at most")
