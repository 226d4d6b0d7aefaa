#!/usr/bin/python3
"""Measures our forces against recorded ones: docs/charts/spring_recording.csv and contour_forces.csv.

Both daemons replay each recording in lockstep, so that the same build gives the same figures.
"""
import pathlib
import subprocess
import tempfile

import numpy

import recorded_forces
from measuring import fail, parser_of
from tables import write_rows


def replay(scene, device, duration_s, build, folder):
    """The recording's file."""
    (folder / "scene.toml").write_text(scene)
    file = folder / "recording.csv"
    subprocess.run(
        [recorded_forces.ROOT / "scripts/launch", folder / "scene.toml", "--lockstep", "--device", device,
         "--duration", str(duration_s), "--record", file, "--build", build],
        check=True, stdout=subprocess.DEVNULL)
    return file


def measure_spring(build, charts, folder):
    spring = recorded_forces.Spring()
    file = replay(spring.scene(), spring.device(), spring.time_s[-1], build, folder)
    time_s, place_m, measured_N, ours_N = spring.compare(file)
    second = time_s >= spring.half_s
    rms_N = numpy.sqrt(((ours_N - measured_N)[second] ** 2).mean())
    print(f"spring {spring.stiffness_N_per_m:.1f} N/m, at rest at {1e3 * spring.rest_m:.3f} mm; second half: "
          f"{rms_N:.4f} N rms, {100.0 * rms_N / measured_N[second].mean():.2f} % of the mean force")
    write_rows(charts / "spring_recording.csv", [
        {"time_s": f"{time_s[i]:.3f}", "place_mm": f"{1e3 * place_m[i]:.4f}",
         "measured_N": f"{measured_N[i]:.4f}", "ours_N": f"{ours_N[i]:.4f}",
         "half": 2 if second[i] else 1} for i in range(0, len(time_s), 5)])


def measure_contour(build, charts, names, folder):
    rows = []
    for name in names:
        row = {"demonstration": name}
        for contact in recorded_forces.CONTACTS:
            file = replay(recorded_forces.contour_scene(contact), recorded_forces.contour_device(name),
                          recorded_forces.contour_duration_s(name), build, folder)
            share, cosine = recorded_forces.compare_contour(name, file)
            row |= {f"in_contact_{contact}": f"{share:.4f}", f"cosine_{contact}": f"{cosine:.4f}"}
        print(f"contour: {row}", flush=True)
        rows.append(row)
    for contact in recorded_forces.CONTACTS:
        print(f"mean cosine, {contact}: {numpy.mean([float(row[f'cosine_{contact}']) for row in rows]):.4f}")
    write_rows(charts / "contour_forces.csv", rows)


def main():
    arguments = parser_of(__doc__, "two demonstrations of eight").parse_args()
    if not recorded_forces.SPRING.exists() or not recorded_forces.CONTOUR_MESH.exists():
        fail(f"{recorded_forces.DATA}: expected the real inputs there")
    names = recorded_forces.DEMONSTRATIONS[:2 if arguments.small else None]
    with tempfile.TemporaryDirectory() as folder:
        measure_spring(arguments.build, arguments.charts, pathlib.Path(folder))
        measure_contour(arguments.build, arguments.charts, names, pathlib.Path(folder))


if __name__ == "__main__":
    main()
