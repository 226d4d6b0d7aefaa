"""stiffness_fit.png: the measured force beside the predicted one, and the map."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy

MEASURED, PREDICTED, ONE = "0.2", "#D55E00", "#0072B2"
LONGEST_S = 12.0  # of what is drawn over time


def flat(points_m):
    """In the plane in which they spread most; millimetres from their middle."""
    middle_m = points_m.mean(axis=0)
    axes = numpy.linalg.svd(points_m - middle_m, full_matrices=False)[2][:2]
    return middle_m, axes


def draw_force(axes, one, best):
    contact = one.track.contact
    time_s = contact.time_s
    seen = time_s <= time_s[0] + LONGEST_S
    # What lies beyond the ruler is not joined by a line.
    gaps = numpy.flatnonzero(numpy.diff(time_s[seen]) > 0.1) + 1
    for colour, width, label, force_N in ((MEASURED, 1.6, "measured", contact.force_N),
                                          (PREDICTED, 1.0, best, one.along_N[best])):
        for i, part in enumerate(numpy.split(numpy.flatnonzero(seen), gaps)):
            axes.plot(time_s[part], force_N[part], color=colour, linewidth=width, label=label if i == 0 else None)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("force along the normal [N]")
    axes.legend(frameon=False, ncol=2, loc="lower right", bbox_to_anchor=(1.0, 1.0))
    axes.set_title(one.track.recording.file.name, loc="left", fontsize=10)


def draw_scatter(axes, one, best):
    measured_N = one.track.contact.force_N[one.touched]
    models = [name for name in one.along_N if name in (best, "field, one stiffness")]
    for name, colour in zip(models, (PREDICTED, ONE)):
        axes.plot(measured_N, one.along_N[name][one.touched], ".", color=colour, markersize=2.5, alpha=0.5,
                  label=f"{name}: R2 {one.R2[name][0]:.3f}")
    most_N = measured_N.max()
    axes.plot((0.0, most_N), (0.0, most_N), color="0.4", linewidth=0.8)
    axes.set_xlabel("measured [N]")
    axes.set_ylabel("predicted [N]")
    axes.legend(frameon=False, fontsize=8.5, markerscale=3)


def draw_map(axes, fit, one):
    feet_m = one.track.contact.foot_m[one.touched]
    middle_m, plane = flat(feet_m)
    if not len(fit.places_m):
        axes.text(0.5, 0.5, f"one stiffness\n{fit.own_N_per_m:.4g} N/m", ha="center", va="center",
                  transform=axes.transAxes)
        axes.set_axis_off()
        return
    points_mm = 1e3 * (feet_m - middle_m) @ plane.T
    places_mm = 1e3 * (fit.places_m - middle_m) @ plane.T
    axes.plot(*points_mm.T, ".", color="0.8", markersize=1.5, zorder=0)
    found = axes.scatter(*places_mm.T, c=fit.stiffness_N_per_m, s=55, cmap="viridis", edgecolors="white",
                         linewidths=0.5)
    axes.figure.colorbar(found, ax=axes, label="stiffness [N/m]")
    axes.set_aspect("equal")
    axes.set_xlabel("along the surface [mm]")


def draw(fit, found, best, file):
    plt.rcParams.update({"font.size": 9.5, "axes.spines.top": False, "axes.spines.right": False})
    figure = plt.figure(figsize=(11.0, 6.4))
    grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.25), height_ratios=(1, 1.3))
    draw_force(figure.add_subplot(grid[0, :]), found[-1], best)
    draw_scatter(figure.add_subplot(grid[1, 0]), found[-1], best)
    draw_map(figure.add_subplot(grid[1, 1]), fit, found[0])
    figure.tight_layout()
    figure.savefig(file, dpi=110, facecolor="white")
    plt.close(figure)
