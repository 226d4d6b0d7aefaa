#!/usr/bin/python3
"""Draws docs/charts/publication_{speed,reads}.png from the tables that measure_publication.py writes."""
from drawing import draw_charts, matplotlib, plt
from tables import read_rows

OURS, THEIRS, REJECTED = "#0072B2", "#888888", "#D55E00"
SOAKS = {"snapshots_1ms": "a tick each ms,\nall 131,072 words",
         "words_512": "a tick each ms,\n512 words",
         "kills": "writers at full speed,\nkilled; 512 words",
         "full_speed": "both at full speed, not\nreal-time; all words"}
PERCENTILES = (("p50_us", "p50"), ("p99_us", "p99"), ("p999_us", "p99.9"))


def in_words(us):
    for unit, factor in (("s", 1e6), ("ms", 1e3)):
        if us >= factor:
            return f"{us / factor:.3g} {unit}"
    return f"{us:.3g} µs"


def draw_speed(charts):
    rows = read_rows(charts / "publication_speed.csv")
    spheres = [int(row["spheres"]) for row in rows]
    publish_us = [float(row["publish_us"]) for row in rows]
    memcpy_us = [float(row["memcpy_us"]) for row in rows]
    figure, (times, ratio) = plt.subplots(2, 1, figsize=(7.6, 6.6), sharex=True,
                                          height_ratios=(3, 1))
    times.plot(spheres, publish_us, "o-", color=OURS, label="publishing a snapshot")
    times.plot(spheres, memcpy_us, "s--", color=THEIRS, markersize=5,
               label="memcpy of as many bytes between private memories")
    times.axhline(1000.0, color="0.8", linewidth=1.0, zorder=0)
    times.text(spheres[0], 1080.0, "1 ms", color="0.5", fontsize=8.5, va="bottom")
    for i, row in enumerate(rows):
        if int(row["spheres"]) in (400, 4000, 40000, 400000):
            size = int(row["bytes"])
            size = f"{size / 1e6:.3g} MB" if size >= 1e6 else f"{size / 1e3:.3g} kB"
            times.annotate(f"{in_words(publish_us[i])}\n{size}",
                           (spheres[i], publish_us[i]), textcoords="offset points",
                           xytext=(-8, 7), ha="right", fontsize=8.5, color=OURS)
    times.set_xscale("log")
    times.set_yscale("log")
    times.set_xlim(spheres[0] / 2.4, spheres[-1] * 1.4)
    times.set_ylim(top=max(publish_us) * 4.0)
    times.set_ylabel("processor time [µs]")
    times.legend(loc="lower right", frameon=False)
    times.grid(axis="y", color="0.93")
    shares = [ours / theirs for ours, theirs in zip(publish_us, memcpy_us)]
    ratio.plot(spheres, shares, "o-", color=OURS)
    ratio.axhline(1.0, color=THEIRS, linestyle="--", linewidth=1.0)
    ratio.set_ylim(0.0, max(2.0, 1.15 * max(shares)))
    ratio.set_ylabel("publish : memcpy")
    ratio.set_xlabel("moving spheres in the snapshot")
    ratio.grid(axis="y", color="0.93")
    ratio.xaxis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda n, _: f"{n:,.0f}"))
    ratio.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    figure.suptitle("Publishing a snapshot of N moving spheres", x=0.02, ha="left",
                    fontsize=13, fontweight="bold")
    figure.tight_layout()
    return figure


def draw_attempts(axes, soaks):
    """Ticks by the attempts that failed, per soak."""
    width = 0.8 / len(soaks)
    shades = plt.get_cmap("viridis")
    for i, row in enumerate(soaks):
        counts = [int(row[f"failed_{k}"]) for k in range(3)]
        places = [k + (i - 0.5 * (len(soaks) - 1)) * width for k in range(3)]
        shown = [max(count, 0.5) for count in counts]
        axes.bar(places, shown, width * 0.92, bottom=0.0, color=shades(0.15 + 0.7 * i / len(soaks)),
                 label=SOAKS[row["soak"]].replace("\n", " "))
        for place, count, height in zip(places, counts, shown):
            axes.text(place, height * 1.15, f"{count:,}", ha="center", va="bottom", fontsize=8,
                      rotation=90)
    axes.set_yscale("log")
    axes.set_ylim(0.5, 60.0 * max(int(row["ticks"]) for row in soaks))
    axes.set_xticks(range(3), ["none:\nread at once", "one:\nread at the second", "both:\nlast "
                               "good sample"])
    axes.set_ylabel("reads")
    axes.set_title("Attempts of a read that were rejected", loc="left", fontsize=10.5,
                   fontweight="bold")
    axes.legend(loc="upper right", frameon=False, fontsize=8)


def draw_times(axes, rows):
    """Percentiles of each soak's read time, and of the timers' lateness."""
    named = [(row, SOAKS[row["soak"]], OURS) for row in rows
             if row["time"] == "read" and row["soak"] in SOAKS]
    named += [(row, "timer of the 512 words:\nhow late it woke", THEIRS) for row in rows
              if row["time"] == "wake" and row["soak"] == "words_512"]
    named += [(row, "cyclictest:\nhow late it woke", THEIRS) for row in rows
              if row["soak"] == "cyclictest"]
    markers = ("o", "D", "|")
    for place, (row, _, colour) in enumerate(named):
        us = [max(float(row[key]), 1.0) for key, _ in PERCENTILES]
        axes.plot(us, [place] * 3, "-", color=colour, linewidth=1.5)
        for value, marker in zip(us, markers):
            axes.plot(value, place, marker, color=colour, markersize=7 if marker != "|" else 13,
                      markeredgewidth=2)
        axes.text(us[-1] * 1.3, place, " / ".join(in_words(value) for value in us), va="center",
                  fontsize=8)
    axes.set_yticks(range(len(named)), [name for _, name, _ in named], fontsize=8.5)
    axes.set_ylim(len(named) - 0.4, -0.9)
    axes.set_xscale("log")
    low, high = axes.get_xlim()
    axes.set_xlim(low, high * 12.0)
    axes.xaxis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda us, _: in_words(us)))
    axes.grid(axis="x", color="0.93")
    axes.set_title("Time of a read: p50 / p99 / p99.9", loc="left", fontsize=10.5,
                   fontweight="bold")


def draw_reads(charts):
    rows = read_rows(charts / "publication_reads.csv")
    by_name = {row["soak"]: row for row in rows if row["time"] == "read"}
    soaks = [by_name[name] for name in SOAKS if name in by_name]
    figure, (attempts, times) = plt.subplots(1, 2, figsize=(13.0, 5.4), width_ratios=(5, 6))
    draw_attempts(attempts, soaks)
    draw_times(times, rows)
    ticks, bad = (sum(int(row[key]) for row in soaks for key in keys)
                  for keys in (("ticks",), ("torn", "backwards")))
    figure.suptitle(f"Reading snapshots of 1 MiB that another process writes: {ticks:,} reads, "
                    f"{bad:,} torn, mixed or backwards", x=0.01, ha="left", fontsize=13,
                    fontweight="bold")
    figure.tight_layout(w_pad=2.5)
    return figure


if __name__ == "__main__":
    draw_charts(__doc__, {"publication_speed": draw_speed, "publication_reads": draw_reads}, dpi=120)
