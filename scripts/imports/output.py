"""Writes the trajectory that replay plays, whole or not at all."""
from whole_file import whole

NAMES = {"position_m": ("x_m", "y_m", "z_m"), "turns": ("qx", "qy", "qz", "qw"), "force_N": ("fx_N", "fy_N", "fz_N")}


def write(trajectory, notes, file):
    """notes: metadata, name and text, a comment each. Numbers in the shortest form that reads back the same."""
    names, columns = ["time_s"], [trajectory.time_s]
    for field, parts in NAMES.items():
        if getattr(trajectory, field) is not None:
            names += parts
            columns += list(getattr(trajectory, field).T)
    rows = zip(*(column.tolist() for column in columns))
    with whole(file) as part:
        with open(part, "w", encoding="utf-8") as stream:
            stream.writelines(f"# {name}: {' '.join(str(text).split())}\n" for name, text in notes)
            stream.write(",".join(names) + "\n")
            stream.writelines(",".join(map(repr, row)) + "\n" for row in rows)
