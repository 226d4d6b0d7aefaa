#!/usr/bin/python3 -IS
"""Stands in for fit_run: error and cost of a scene with one sheet are formulas, so that the best is known.

It writes a line into runs.log beside itself for each candidate, sleeps where there is a file `slow`, cannot start where
there is a file `full`, and errs by a half more along a trajectory whose name has `far`.
"""
import json
import math
import os
import re
import sys
import time

SHOWN = {"predict": 1.0, "linear": 3.0, "hold": 2.0}
GIVEN_M = 0.01
HERE = os.path.dirname(os.path.abspath(__file__))


def error(rate_hz, transition, spacing_m, scale):
    """Late by a period, coarse by the spacing, and wrong where the stiffness does not follow it."""
    late = 0.45 * SHOWN.get(transition, 4.0) / rate_hz
    coarse = 0.012 * ((spacing_m / GIVEN_M) ** 2 - 1.0)
    return math.hypot(late, coarse, 0.5 * (scale * GIVEN_M ** 2 / actual_m(spacing_m) ** 2 - 1.0))


def actual_m(spacing_m):
    """The spacing as it comes out along 0.14 m."""
    return 0.14 / int(0.14 / spacing_m + 0.5)


def cost_us(rate_hz, transition, spacing_m, integrator):
    spheres = (int(0.14 / spacing_m + 0.5) + 1) ** 2
    return rate_hz * spheres * (0.002 if integrator == "implicit_euler" else 0.001) + 1.0 + (transition == "predict")


def is_stable(rate_hz, stiffness_N_per_m):
    return stiffness_N_per_m <= 50.0 * rate_hz


def value_of(text, key, kind=float):
    """Of a scene's only such key."""
    found = re.search(rf"^[^#\n]*\b{key}\s*=\s*([^,}}\s#]+)", text, re.M)
    return kind(found[1].strip('"')) if found else None


def parsed(arguments):
    """Scene, --set as text, and the other options."""
    scene, *rest = arguments
    options, settings = {}, []
    while rest:
        name = rest.pop(0)
        if name == "--search-margin":
            options[name] = True
        elif name == "--set":
            settings.append(rest.pop(0))
        else:
            options[name] = rest.pop(0)
    return scene, "\n".join(re.sub(r"^.*\.(\w+=)", r"\1", setting) for setting in settings), options


def candidate(text, settings, options, is_faulty=False):
    """What fit_run prints of a scene's text."""
    def value(key, kind=float):
        mine = value_of(settings, key, kind)
        return value_of(text, key, kind) if mine is None else mine
    rate_hz = value_of(settings, "rate_hz") or value_of(text, "rate_hz") or 1.0 / value_of(text, "period_s")
    transition = options.get("--transition", "predict")
    spacing_m, scale = value("spacing_m"), value("stiffness_scale") or 1.0
    share = error(rate_hz, transition, spacing_m, scale)
    if "far" in options.get("--trajectory", ""):
        share += 0.5
    if is_faulty and value("voxel_ratio"):
        share += 0.003
    stiffness_N_per_m = value("contact_stiffness_N_per_m")
    stability = {"stable": is_stable(rate_hz, float(options.get("--margin", 1.0)) * stiffness_N_per_m), "swing_m": 0.0}
    if "--search-margin" in options:
        stability["largest_margin"] = 50.0 * rate_hz / stiffness_N_per_m
    return {"settings": {"latency_share": 0.1}, "reference": {"force_rms_N": 1.0, "contact_share": 0.5},
            "error": {"rms_N": share, "share": share, "jnd": share / 0.07},
            "cost": {"processor_us_per_ms": cost_us(rate_hz, transition, spacing_m, value("integrator", str)),
                     "step_share": 0.1},
            "counts": {"spheres": 225}, "stability": stability if "--margin" in options else None, "problems": []}


def main():
    scene, settings, options = parsed(sys.argv[1:])
    if "--write-reference" in options:
        for name in (options["--write-reference"], options["--write-reference"].replace(".csv", ".state.csv")):
            with open(name, "w") as stream:
                stream.write("the truth\n")
        return
    for name in (options["--reference"], options["--trajectory"]):
        open(name).close()  # they must have been sent along
    with open(os.path.join(HERE, "runs.log"), "a") as log:
        log.write(" ".join(sys.argv[1:]) + "\n")
    if os.path.exists(os.path.join(HERE, "slow")):
        time.sleep(0.1)
    if os.path.exists(os.path.join(HERE, "full")) and "integrator" in settings:
        sys.stderr.write("fit_run: /tmp: no space left\n")
        sys.exit(2)
    for what, status, line in (("refuse", 1, "no such integrator"), ("crash", 3, "broken")):
        if f"integrator={what}" in settings:
            sys.stderr.write(f"fit_run: {line}\n")
            sys.exit(status)
    with open(scene) as stream:
        result = candidate(stream.read(), settings, options)
    result["arguments"] = " ".join(sys.argv[1:])
    print(json.dumps(result))


if __name__ == "__main__":
    main()
