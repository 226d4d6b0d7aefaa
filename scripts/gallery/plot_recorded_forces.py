#!/usr/bin/python3
"""Draws docs/charts/spring_recording.png from the table that measure_recorded_forces.py writes."""
import numpy

from drawing import draw_charts, plt
from tables import read_rows

MEASURED, OURS = "#0072B2", "#D55E00"


def draw(charts):
    rows = read_rows(charts / "spring_recording.csv")
    time_s, place_mm, measured_N, ours_N, half = (
        numpy.array([float(row[key]) for row in rows])
        for key in ("time_s", "place_mm", "measured_N", "ours_N", "half"))
    second = half == 2
    rms_N = numpy.sqrt(((ours_N - measured_N)[second] ** 2).mean())

    figure = plt.figure(figsize=(10.4, 5.6))
    grid = figure.add_gridspec(2, 2, width_ratios=(2.1, 1), height_ratios=(2.2, 1))
    force, off, law = (figure.add_subplot(grid[cell]) for cell in ((0, 0), (1, 0), (slice(None), 1)))

    force.axvspan(0.0, time_s[second][0], color="0.93", zorder=0)
    force.text(0.17, 0.6, "ramp of the start", color="0.4")
    force.text(0.05, 6.3, "the wall is fitted to this half", color="0.4")
    force.text(time_s[second][0] + 0.05, 6.3, "and tried on this one", color="0.4")
    force.plot(time_s, measured_N, color=MEASURED, label="measured")
    force.plot(time_s, ours_N, color=OURS, linewidth=1.0, label="ours, both daemons in lockstep")
    force.set_ylabel("force of the spring [N]")
    force.set_ylim(0, 6.8)
    force.legend(frameon=False, loc="lower right")

    off.axvspan(0.0, time_s[second][0], color="0.93", zorder=0)
    off.axhline(0.0, color="0.7", linewidth=0.8)
    off.plot(time_s, ours_N - measured_N, color="0.2", linewidth=1.0)
    off.set_ylabel("ours less measured [N]")
    off.set_xlabel("time [s]")
    off.set_ylim(-0.4, 0.4)
    for axes in (force, off):
        axes.set_xlim(0, time_s[-1])

    law.plot(place_mm[second], measured_N[second], color=MEASURED, linewidth=1.0)
    law.plot(place_mm[second], ours_N[second], color=OURS, linewidth=1.0)
    law.set_xlabel("place of the tip [mm]")
    law.set_ylabel("force in the second half [N]")
    law.text(0.03, 0.95, f"{rms_N:.2f} N rms,\n{100 * rms_N / measured_N[second].mean():.1f} % of the mean force",
             transform=law.transAxes, va="top", color="0.2")
    figure.suptitle("A lever pressed against a spring (TU/e, 1 degree of freedom, 2 kHz)",
                    x=0.01, ha="left", fontsize=12, fontweight="bold")
    figure.tight_layout(rect=(0, 0, 1, 0.97), w_pad=2.0)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"spring_recording": draw})
