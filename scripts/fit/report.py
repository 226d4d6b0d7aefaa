"""What a fit tells: the table on standard output, fit.json, runs.csv."""
import csv
import io
import json

from candidates import method_text

JUST_NOTICEABLE = 0.07  # of a force (docs/cases.md, case 1.15)
FAINT_N = 0.1  # a share of a force that is less would be noticed by nobody: it is taken of this

COLUMNS = ("stage", "rate_hz", "transition", "method", "levels", "voxel_ratio", "spheres", "cost_us_per_ms",
           "simulation_us_per_ms", "tick_p50_us", "latency_share", "step_share", "error_share", "jnd", "jnd_p95",
           "felt_share", "alone", "stable", "largest_margin", "role", "verdict")


def at(result, *keys):
    for key in keys:
        result = (result or {}).get(key)
    return result


def error_of(result):
    """The force's rms error over the true force's rms, or FAINT_N where that is less; None without contact."""
    rms_N, share = at(result, "error", "rms_N"), at(result, "error", "share")
    if rms_N is None:
        return None
    true_N = rms_N / share if share else at(result, "reference", "force_rms_N") or 0.0
    return rms_N / max(true_N, FAINT_N)


def jnd_of(error):
    return None if error is None else error / JUST_NOTICEABLE


def verdict(trial, goal):
    return "; ".join(trial.faults(goal)) or "fits"


def row_of(trial, space, goal):
    candidate, result = trial.candidate, trial.result
    levels = [f"{group.name}: {group.levels[level].label}" for group, level in zip(space.groups, candidate.levels)
              if level]
    return {
        "stage": trial.stage, "rate_hz": candidate.rate_hz,
        "transition": candidate.transition, "method": method_text(candidate.method), "levels": "; ".join(levels),
        "voxel_ratio": candidate.voxel_ratio, "spheres": at(result, "counts", "spheres"),
        "cost_us_per_ms": at(result, "cost", "processor_us_per_ms"),
        "simulation_us_per_ms": at(result, "cost", "simulation_us_per_ms"),
        "tick_p50_us": at(result, "cost", "tick_us", "p50"), "latency_share": trial.latency_share,
        "step_share": at(result, "cost", "step_share"), "error_share": error_of(result),
        "jnd": jnd_of(error_of(result)), "jnd_p95": at(result, "error", "jnd_p95"),
        "felt_share": at(result, "error", "felt_share"), "alone": trial.alone, "stable": trial.is_stable(),
        "largest_margin": at(trial.stability, "largest_margin"), "role": "", "verdict": verdict(trial, goal)}


def runs_csv(rows):
    stream = io.StringIO()
    writer = csv.DictWriter(stream, fieldnames=COLUMNS, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({key: "" if value is None else value for key, value in row.items()})
    return stream.getvalue()


def summary_of(trial, space, goal):
    """A trial as fit.json has it."""
    if trial is None:
        return None
    return {**row_of(trial, space, goal), "description": space.describe(trial.candidate),
            "changes": {".".join(map(str, path)): value for path, value in space.changes(trial.candidate).items()},
            "haptic_server_options": trial.candidate.haptic_options(),
            "result": trial.result, "stability": trial.stability}


def json_text(fit):
    return json.dumps(fit, indent=2) + "\n"


def percent(value):
    return "-" if value is None else f"{100 * value:.3g} %"


def number(value, form="{:.3g}"):
    return "-" if value is None else form.format(value)


def missed(fit, goal):
    """Why the exit status is not that of a fit; nothing where it is."""
    if not fit["fits"]:
        return f"{fit['choice']['verdict']}: the closest to {goal.describe()} is shown"
    if fit["check"] and fit["check"]["choice"]["verdict"] != "fits":
        return f"on {fit['check']['trajectory']}, which the fit did not see: {fit['check']['choice']['verdict']}"
    return None


def table(rows):
    """Rows of text in columns as wide as they need."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return "".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() + "\n" for row in rows)


def printed(fit):
    """The whole answer, as text."""
    rows = [("", "us per ms", "error", "JND", "margin", "spheres", "")]
    found = "choice" if fit["fits"] else "closest"
    for label, key in (("as given", "given"), (found, "choice"), ("next cheaper", "next_cheaper")):
        one = fit[key]
        if one is None:
            continue
        rows.append((label, number(one["cost_us_per_ms"]), percent(one["error_share"]), number(one["jnd"], "{:.2f}"),
                     number(one["largest_margin"]), str(one["spheres"]), one["description"]))
        if one["verdict"] != "fits":
            rows.append(("", "", "", "", "", "", f"FAILS: {one['verdict']}"))
    for label, key in (("unseen, as given", "given"), (f"unseen, {found}", "choice")):
        if fit["check"]:
            one = fit["check"][key]
            rows.append((label, number(one["cost_us_per_ms"]), percent(one["error_share"]),
                         number(one["jnd"], "{:.2f}"), "", "", fit["check"]["trajectory"]))
            if one["verdict"] != "fits":
                rows.append(("", "", "", "", "", "", f"FAILS: {one['verdict']}"))
    return table(rows)
