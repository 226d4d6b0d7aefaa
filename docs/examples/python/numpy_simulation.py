#!/usr/bin/python3
"""A bed of pins on springs, simulated in numpy at 50 Hz and felt at 1 kHz (docs/python.md)."""
import numpy
import stillgrid

SIDE, SPACING_m, RADIUS_m, PERIOD_s = 9, 0.012, 0.010, 0.02
MASS_kg, DAMPING_N_s_per_m, SPRING_N_per_m = 0.02, 1.0, 100.0
COUNT = SIDE * SIDE
SCENE = stillgrid.Scene(PERIOD_s, COUNT, [stillgrid.Material(500.0, friction=0.3)], predicts=True)


def simulate(publisher):
    bodies = numpy.arange(COUNT)
    row, column = numpy.divmod(bodies, SIDE)
    positions_m = SPACING_m * numpy.column_stack([row - SIDE // 2, column - SIDE // 2, 0 * row])
    velocities_m_s = numpy.zeros((COUNT, 3))
    # An implicit step, and so how a pin gives way over it, its spring included: up and down alone.
    inertia_kg = MASS_kg + PERIOD_s * DAMPING_N_s_per_m + PERIOD_s**2 * SPRING_N_per_m
    inverse_inertias = numpy.zeros((COUNT, 6, 6))
    inverse_inertias[:, 2, 2] = 1 / inertia_kg

    held_N = numpy.zeros(COUNT)
    publisher.set_shapes(numpy.full(COUNT, RADIUS_m), bodies=bodies)
    for _ in publisher.steps():
        publisher.set_spheres(positions_m, velocities_m_s)
        forces_N = held_N - SPRING_N_per_m * positions_m[:, 2]
        velocities_m_s[:, 2] = (MASS_kg * velocities_m_s[:, 2] + PERIOD_s * forces_N) / inertia_kg
        publisher.set_trial(velocities_m_s)  # as if the last step's pushes stayed
        publisher.set_responses(bodies, positions_m, inverse_inertias)
        pushes = publisher.pushes()
        velocities_m_s[:, 2] -= PERIOD_s * held_N / inertia_kg
        held_N[:] = 0
        held_N[pushes.body] = pushes.force_N[:, 2]
        velocities_m_s[:, 2] += PERIOD_s * held_N / inertia_kg
        publisher.set_predicted(velocities_m_s)
        publisher.publish()
        positions_m += PERIOD_s * velocities_m_s


if __name__ == "__main__":
    with stillgrid.Session(device="phantom:hand=light,path=press,depth_m=0.03", duration_s=5) as session:
        with session.publish(SCENE) as publisher:
            simulate(publisher)
    print(f"felt {session.report['ticks']} ticks, {session.report['force_N']['max']:.2f} N at most")
