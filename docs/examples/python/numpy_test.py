"""The pins feel as they felt: a recorded hand, replayed in virtual time (docs/python.md).

    pytest numpy_test.py                              compares
    pytest numpy_test.py --stillgrid-write-expected   accepts what is felt today
"""
import numpy_simulation


def test_the_pins_feel_as_they_felt(stillgrid_session):
    run = stillgrid_session.replay(numpy_simulation.SCENE, "press.csv", numpy_simulation.simulate,
                                   options="resample=cubic")
    stillgrid_session.assert_forces(run, "press_forces.csv", tolerance_N=0.01)
