"""What a stiffness fit tells and writes: its table, the fitted scene, the map, stiffness_fit.json and .png."""
import dataclasses
import json
import math
import os
import pathlib
import shutil
import tempfile

import numpy

JSON_VERSION = 1


@dataclasses.dataclass
class Figures:
    """Of one recording. R2: by model, along the normal and of the size. along_N: by model that the servers ran."""

    track: object
    touched: numpy.ndarray
    R2: dict
    along_N: dict


def rounded(value):
    return float(f"{value:.6g}") if math.isfinite(value) else None


def map_text(fit, head):
    rows = [f"{x:.6g},{y:.6g},{z:.6g},{stiffness:.6g}"
            for (x, y, z), stiffness in zip(fit.places_m, fit.stiffness_N_per_m)]
    return "\n".join([f"# {head}", "x_m,y_m,z_m,stiffness_N_per_m", *rows]) + "\n"


def forces_text(figures):
    """A row a row of the recording near the body: along the normal, measured and by each model that was replayed."""
    names = [f"{name.replace(', ', ' ').replace(' ', '_')}_N" for name in figures.along_N]
    contact = figures.track.contact
    columns = (contact.time_s, contact.gap_m, figures.touched, contact.force_N, *figures.along_N.values())
    rows = [",".join(f"{value:.6g}" for value in row) for row in zip(*columns)]
    return "\n".join([",".join(("time_s", "gap_m", "in_contact", "measured_N", *names)), *rows]) + "\n"


def stiffness_line(fit):
    if not len(fit.places_m):
        return f"{fit.own_N_per_m:.4g} N/m, one for the whole body"
    low, high = fit.stiffness_N_per_m.min(), fit.stiffness_N_per_m.max()
    return (f"{low:.4g} to {high:.4g} N/m, {len(fit.places_m)} places {1e3 * fit.spacing_m:.2g} mm apart, elsewhere "
            f"{fit.own_N_per_m:.4g} N/m")


def recording_line(figures):
    contact, touched = figures.track.contact, figures.touched
    depth_mm = -1e3 * contact.gap_m.min()
    text = (f"{figures.track.recording.file}: {touched.sum()} of {len(figures.track.recording.time_s)} rows in "
            f"contact, {depth_mm:.2g} mm deep in the mesh, {contact.force_N.max():.3g} N")
    if figures.track.far_N > 0.2 * contact.force_N.max():
        text += f"; WARNING: {figures.track.far_N:.3g} N where the tool does not reach the body"
    return text


def text(scene, fit, found, best, arguments):
    lines = [f"body '{scene.body['name']}' of {scene.file}"]
    lines += [("fitted to  " if i == 0 else "predicted  ") + recording_line(one) for i, one in enumerate(found)]
    lines += [f"stiffness  {stiffness_line(fit)}",
              f"surface    {1e3 * abs(fit.offset_m):.2f} mm {'outside' if fit.offset_m >= 0 else 'inside'} of the mesh"]
    if arguments.offset and abs(fit.offset_m) > 0.999 * arguments.offset:
        lines.append("WARNING: that is as far as was looked for: is the recording laid well onto the mesh? --offset")
    if math.isfinite(fit.cross_R2):
        lines.append(f"left out   a fifth at a time, R2 {fit.cross_R2:.3f}, by one stiffness {fit.one_cross_R2:.3f}")
    columns = ["fitted to", "predicted"][:len(found)]
    lines.append(f"{'R2 along the normal, of the size':34}" + "".join(f"{name:>18}" for name in columns))
    for name in found[0].R2:
        pairs = "".join(f"{one.R2[name][0]:>10.3f}{one.R2[name][1]:>8.3f}" for one in found)
        lines.append(f"  {name:32}{pairs}" + ("   <- written" if name == best else ""))
    return "\n".join(lines) + "\n"


class Files:
    def __init__(self, scene, fit, arguments, out):
        self.scene, self.fit, self.arguments, self.out = scene, fit, arguments, out
        self.scene_file = out / f"{scene.file.stem}_fitted.toml"
        self.others = ["stiffness_fit.json", "forces.csv"]
        if len(fit.places_m):
            self.others.insert(0, "stiffness_map.csv")

    def head(self, R2=None):
        lines = [f"Fitted by stiffness_fit to {self.arguments.recording.name}: body '{self.scene.body['name']}',",
                 f"  {stiffness_line(self.fit)}"]
        return lines + ([f"  R2 {R2:.3f} along the normal on {self.judged}"] if R2 is not None else [])

    @property
    def judged(self):
        return (self.arguments.check or self.arguments.recording).name

    def trial(self, folder, fit):
        """A scene with these values in another folder, to be replayed."""
        inside = pathlib.Path(tempfile.mkdtemp(dir=folder))
        self.put(inside, inside, fit, [])
        return inside / self.scene_file.name

    def put(self, inside, meant, fit, head):
        """inside: where the files are written; meant: the folder that paths in the scene start from."""
        has_map = len(fit.places_m) > 0
        if has_map:
            (inside / "stiffness_map.csv").write_text(map_text(fit, "by stiffness_fit"))
        text_ = self.scene.fitted(fit, "stiffness_map.csv" if has_map else None, meant, head)
        (inside / self.scene_file.name).write_bytes(text_.encode())

    def json(self, found, best):
        fit = self.fit
        return {"version": JSON_VERSION, "scene": str(self.scene.file), "body": self.scene.body["name"],
                "own_N_per_m": rounded(fit.own_N_per_m), "offset_m": rounded(fit.offset_m),
                "places": len(fit.places_m), "spacing_m": rounded(fit.spacing_m),
                "smoothness": rounded(fit.smoothness), "cross_R2": rounded(fit.cross_R2),
                "one_stiffness_cross_R2": rounded(fit.one_cross_R2), "written": best,
                "recordings": [{"file": str(one.track.recording.file), "rows": len(one.track.recording.time_s),
                                "rows_in_contact": int(one.touched.sum()),
                                "R2": {name: {"along_normal": rounded(pair[0]), "size": rounded(pair[1])}
                                       for name, pair in one.R2.items()}} for one in found]}

    def write(self, found, best):
        """All beside where they go first, so that none is missing if the disk is full; the scene last."""
        self.out.mkdir(exist_ok=True)
        inside = pathlib.Path(tempfile.mkdtemp(prefix=".part-", dir=self.out))
        try:
            self.put(inside, self.out, self.fit, self.head(found[-1].R2[best][0]))
            (inside / "forces.csv").write_text(forces_text(found[-1]))
            (inside / "stiffness_fit.json").write_text(json.dumps(self.json(found, best), indent=2) + "\n")
            try:
                import stiffness_picture
                stiffness_picture.draw(self.fit, found, best, inside / "stiffness_fit.png")
                self.others.append("stiffness_fit.png")
            except ImportError:
                print("no picture: no matplotlib")
            for name in [*self.others, self.scene_file.name]:
                os.replace(inside / name, self.out / name)
        finally:
            shutil.rmtree(inside, ignore_errors=True)
