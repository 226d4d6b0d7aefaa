"""What a fit prints and writes."""
import csv
import json
import math

import messages

JUST_NOTICEABLE = 0.07  # of a force (docs/cases.md, case 1.15)


def row_of(trial, search, role=""):
    return {"candidate": search.scene.describe(trial.candidate), "rate_hz": trial.candidate.rate_hz,
            "transition": trial.candidate.transition, "cost_us_per_ms": trial.cost_us,
            "error_share": None if trial.error == math.inf else trial.error,
            "truth_error_share": max(record["truth_error_share"] for record in trial.records),
            "spheres": trial.records[0]["spheres"], "stable": (trial.stability or {}).get("stable"),
            "largest_margin": (trial.stability or {}).get("largest_margin"), "role": role,
            "verdict": "; ".join(trial.faults(search.goal)) or "fits"}


def draw(fit, file):
    try:
        import matplotlib
    except ImportError:
        return messages.note("no picture: no matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(figsize=(9.5, 6.2))
    for rows, form, label in (([row for row in fit["runs"] if row["verdict"] == "fits"], "o", "fits"),
                              ([row for row in fit["runs"] if row["verdict"] != "fits"], "x", "does not"),
                              ([fit["given"]], "s", "as given"), ([fit["choice"]], "*", "choice")):
        rows = [row for row in rows if row["error_share"] is not None and row["cost_us_per_ms"] > 0.0]
        axes.plot([row["cost_us_per_ms"] for row in rows], [max(100 * row["error_share"], 0.1) for row in rows], form,
                  label=label, markersize=14 if form == "*" else 6)
    axes.axhline(100 * fit["force_error"], color="#B00020", label="tolerance")
    axes.axhline(100 * JUST_NOTICEABLE, color="0.5", linestyle="--", label="just noticeable 7 %")
    axes.set(xscale="log", yscale="log", xlabel="counted cost of the simulation [µs per ms simulated]",
             ylabel="rms error of the force [% of its rms]", title=fit["scene"])
    axes.legend(frameon=False)
    figure.savefig(file, dpi=120, facecolor="white")
    return None


def printed(fit):
    rows = [("", "us per ms", "error", "JND", "margin", "spheres", "")]
    for label, row in (("as given", fit["given"]), ("choice" if fit["fits"] else "closest", fit["choice"]),
                       ("unseen", fit["check"])):
        if row:
            error = row["error_share"]
            rows.append((label, f"{row['cost_us_per_ms']:.3g}", "-" if error is None else f"{100 * error:.3g} %",
                         "-" if error is None else f"{error / JUST_NOTICEABLE:.2f}", str(row["largest_margin"] or "-"),
                         str(row["spheres"]), row["candidate"]))
            if row["verdict"] != "fits":
                rows.append(("", "", "", "", "", "", f"FAILS: {row['verdict']}"))
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return "".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() + "\n" for row in rows)


def write(fit, scene, choice, out):
    row = fit["choice"]
    head = [f"Fitted by scene_fit to {fit['trajectory']}, "
            f"{'to within' if fit['fits'] else 'the closest to'} {100 * fit['force_error']:.3g} % of the force:",
            f"  {row['candidate']}", f"  error {100 * row['error_share']:.3g} % of the force, "
            f"{row['cost_us_per_ms']:.3g} us of a processor per ms by counts; as given "
            f"{fit['given']['cost_us_per_ms']:.3g} us",
            f"Run it with: haptic_server --transition {choice.candidate.transition}"]
    if not fit["fits"]:
        head.append(f"It FAILS: {row['verdict']}")
    (out / f"{fit['scene']}_fitted.toml").write_text(scene.text_of(choice.candidate, out, head=head), encoding="utf-8",
                                                     newline="")
    (out / "fit.json").write_text(json.dumps(fit, indent=2) + "\n")
    with open(out / "runs.csv", "w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, fieldnames=row.keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(fit["runs"])
    draw(fit, out / "fit.png")
