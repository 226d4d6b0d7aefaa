"""A scene with one sheet, for fake_fit_run, and what is best of it by its formulas."""
import itertools

import fake_fit_run

SCENE = """# A sheet, for formulas.
format = 2

[simulation]   # how it runs
period_s = 0.02  # 50 Hz
integrator = "velocity_verlet"

[[material]]
name = "skin"
contact_stiffness_N_per_m = 200.0

[[body]]
name = "sheet"
kind = "sheet"
size_m = [0.14, 0.14]
nodes = [8, 8]
spheres = { spacing_m = 0.01, radius_m = 0.0065 }  # even
material = "skin"
# The end.
"""
SPACINGS_M = (0.01, 0.0141, 0.02, 0.028)
RATES_HZ = (10.0, 33.0, 50.0, 100.0)


def candidates():
    """All that the small grid can reach: (cost, error, rate, transition, spacing)."""
    for rate_hz, transition, spacing_m, integrator in itertools.product(
            RATES_HZ, fake_fit_run.SHOWN, SPACINGS_M, ("velocity_verlet", "implicit_euler")):
        scale = float(f"{(fake_fit_run.actual_m(spacing_m) / 0.01) ** 2:.6g}")
        yield (fake_fit_run.cost_us(rate_hz, transition, spacing_m, integrator),
               fake_fit_run.error(rate_hz, transition, spacing_m, scale), rate_hz, transition, spacing_m)


def cheapest(tolerance, stiffness_N_per_m=400.0):
    return min(one for one in candidates()
               if one[1] <= tolerance and fake_fit_run.is_stable(one[2], stiffness_N_per_m))


def assert_is(test, one, expected):
    cost_us, error, rate_hz, transition, _ = expected
    test.assertEqual((one["rate_hz"], one["transition"]), (rate_hz, transition))
    test.assertAlmostEqual(one["cost_us_per_ms"], cost_us)
    test.assertAlmostEqual(one["error_share"], error)
