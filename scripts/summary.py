#!/usr/bin/python3
"""Prints what the two reports of a run say, beside a baseline of the machine's own latency.

The baseline is the JSON of cyclictest at a period of 1 ms. A deadline counts as missed when the
loop woke more than one period after it; the baseline's are counted alike.
"""
import argparse
import json
import pathlib
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parent / "gallery"))
import cyclictest

BASELINE_PERIOD_US = 1000


def load(file):
    return json.loads(pathlib.Path(file).read_text())


def share(part, whole):
    return f"{100.0 * part / max(whole, 1):.2f} %"


def print_row(name, text):
    print(f"  {name:<12}{text}")


def print_haptic(report):
    ticks, missed = report["ticks"], report["missed_ticks"]
    force_N = report["force_N"]
    print_row("ticks", f"{ticks} at {report['rate_hz']:g} Hz, {missed} missed "
              f"({share(missed, ticks)})")
    if "tick_ns" in report:  # lockstep has no wall time
        tick_ns, wake_ns = report["tick_ns"], report["wake_ns"]
        print_row("wake", f"p50 {1e-3 * wake_ns['p50']:.0f} us, p99 {1e-3 * wake_ns['p99']:.0f} us, "
                  f"max {1e-3 * wake_ns['max']:.0f} us")
        print_row("tick", f"p50 {1e-3 * tick_ns['p50']:.1f} us, p99 {1e-3 * tick_ns['p99']:.1f} us")
        print_row("rights", rights(report["scheduling"]))
    print_row("contact", f"{report['contact_ticks']} ticks ({share(report['contact_ticks'], ticks)})")
    print_row("force", f"mean {force_N['mean']:.2f} N, max {force_N['max']:.2f} N")
    print_row("snapshot", f"age p50 {1e3 * report['age_s']['p50']:.0f} ms, "
              f"p99 {1e3 * report['age_s']['p99']:.0f} ms")
    interventions = {name: count for name, count in report["safety"].items() if count}
    print_interface(report["interface"])
    print_row("safety", ", ".join(f"{name} {count} ticks" for name, count in interventions.items())
              or "no intervention")


def rights(scheduling):
    ways = {"fifo": "SCHED_FIFO at {priority}", "rtkit": "RealtimeKit's priority {priority}",
            "other": "no real-time priority"}
    return (ways[scheduling["way"]].format_map(scheduling) + (", lost since" if scheduling["was_demoted"] else "")
            + (", memory locked" if scheduling["is_memory_locked"] else ", memory not locked"))


def print_interface(energy):
    """Both sides' account of what the hand and the scene gave each other."""
    if energy is None:
        return print_row("interface", "no account: no snapshot had the tool, or one could not be true")
    mJ = {name.removesuffix("_J"): 1e3 * joules for name, joules in energy.items() if joules is not None}
    most = f"; at most {mJ['most_made_in_a_second']:.3g} in a second" if "most_made_in_a_second" in mJ else ""
    print_row("interface", f"the hand gave {mJ['given_by_hand']:.3g} mJ ({mJ['in_flight']:.3g} in flight), the "
              f"simulation booked {mJ['booked']:.3g}, walls hold {mJ['held']:.3g}, the interface made {mJ['made']:.3g} "
              f"+- {mJ['uncertainty']:.3g}{most}")
    return None


def print_baseline(report):
    histogram = cyclictest.wake_ups(report)
    cycles = sum(histogram.values())
    if not cycles:
        return
    missed = sum(count for us, count in histogram.items() if us > BASELINE_PERIOD_US)
    print_row("baseline", f"cyclictest, {cycles} cycles right after: {missed} missed "
              f"({share(missed, cycles)}), p50 {cyclictest.percentile_us(histogram, 0.5)} us, "
              f"p99 {cyclictest.percentile_us(histogram, 0.99)} us, max {report['thread']['0']['max']} us")


def print_sim(report):
    solver = report["solver"]
    print_row("steps", f"{report['steps']} at {report['rate_hz']:g} Hz, {report['late_steps']} late; "
              f"{report['moving_spheres']} moving spheres")
    if "step_ms" in report:
        step_ms = report["step_ms"]
        print_row("step", f"p50 {step_ms['p50']:.2f} ms, p99 {step_ms['p99']:.2f} ms")
    print_row("solver", f"{solver['name']}, {solver['iterations']:.1f} iterations a step, "
              f"{solver['not_converged']} steps not converged, {solver['out_of_budget']} out of budget")
    print_row("sleeping", f"{share(report['sleeping_spheres'], report['moving_spheres'])} of the moving "
              "spheres, on average")
    energy_mJ = {name.removesuffix("_J"): 1e3 * joules for name, joules in report["energy"].items()}

    def listed(names):
        return ", ".join(f"{name.replace('_', ' ')} {energy_mJ[name]:.3g}" for name in names)

    print_row("energy", listed(("kinetic", "gravity", "springs", "contacts")) + " mJ at the end")
    print_row("flows", listed(("given", "tool_work", "spring_damping", "contact_damping", "friction", "sleep_loss",
                               "numerical")) + " mJ")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("haptic", metavar="HAPTIC.json")
    parser.add_argument("sim", metavar="SIM.json")
    parser.add_argument("--baseline", metavar="FILE.json", help="of cyclictest --json")
    arguments = parser.parse_args()
    try:
        haptic, sim = load(arguments.haptic), load(arguments.sim)
        print(f"haptic_server, {haptic['device']}, {haptic['transition']}")
        print_haptic(haptic)
        if arguments.baseline:
            print_baseline(load(arguments.baseline))
        print(f"sim_server, {sim['scene']}")
        print_sim(sim)
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"summary: {type(error).__name__}: {error}")


if __name__ == "__main__":
    main()
