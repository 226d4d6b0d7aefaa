#!/usr/bin/python3
"""The numpy example, felt by the hand of its test: the force on the hand, what the simulation was told, and a cut
through the bed. In virtual time, so that a build gives one table."""
import os
import sys

import numpy

from measuring import ROOT, parser_of
import recording  # for the package's path
from tables import write_rows

EXAMPLES = ROOT / "docs/examples/python"
EVERY_MS, CUT_S = 4, 0.88


class Watched:
    """A Publisher whose pushes are kept, and the state at one time."""

    def __init__(self, publisher):
        self.publisher, self.pushed_N, self.cut_m = publisher, [], None

    def __getattr__(self, name):
        return getattr(self.publisher, name)

    def set_spheres(self, positions_m, velocities_m_s):
        self.positions_m = positions_m.copy()
        self.publisher.set_spheres(positions_m, velocities_m_s)

    def pushes(self):
        pushes = self.publisher.pushes()
        if len(self.pushed_N) * self.publisher.scene.period_s <= CUT_S:
            self.cut_m = self.positions_m
        self.pushed_N.append(-pushes.force_N[:, 2].sum())
        return pushes


def main():
    arguments = parser_of(__doc__, "the same: it is small").parse_args()
    os.environ["STILLGRID_LIBRARY"] = str(arguments.build / "lib/libstillgrid.so.1")
    sys.path.append(str(EXAMPLES))
    import numpy_simulation as pins
    import stillgrid

    watched = []

    def simulate(publisher):
        watched.append(Watched(publisher))
        pins.simulate(watched[0])

    run = stillgrid.replay(pins.SCENE, EXAMPLES / "press.csv", simulate, options="resample=cubic").recording
    pushed_N = numpy.array(watched[0].pushed_N)
    step = numpy.minimum((run.time_s / pins.PERIOD_s + 1e-6).astype(int), len(pushed_N) - 1)
    columns = {"time_s": run.time_s, "z_m": run["z_m"], "felt_fz_N": run["fz_N"], "pushed_fz_N": pushed_N[step]}
    write_rows(arguments.charts / "python_pins.csv", [
        {name: f"{values[row]:.6f}" for name, values in columns.items()} for row in range(0, len(run), EVERY_MS)])
    write_rows(arguments.charts / "python_pins_cut.csv", list(
        cut(watched[0].cut_m, run.position_m[numpy.searchsorted(run.time_s, CUT_S)], pins.RADIUS_m)))


def cut(pins_m, tool_m, radius_m):
    """The tool and the row of pins under it."""
    row_y_m = pins_m[abs(pins_m[:, 1] - tool_m[1]).argmin(), 1]
    for what, (x_m, _, z_m), radius in (("tool", tool_m, 0.005), *(
            ("pin", pin_m, radius_m) for pin_m in pins_m if pin_m[1] == row_y_m)):
        yield {"what": what, "x_m": f"{x_m:.6f}", "z_m": f"{z_m:.6f}", "radius_m": radius}


if __name__ == "__main__":
    main()
