"""Recordings of haptic_server are in the scene's frame, a trajectory is in that of the hand's device."""


def is_recording(file):
    """Returns whether the columns are those of haptic_server --record, or the first line names the scene of an import."""
    with open(file, encoding="utf-8", errors="replace") as lines:
        first = next(lines, "")
        header = next((line for line in (first, *lines) if not line.startswith("#")), "")
    return first.startswith("# scene: ") or "rendered_fx_N" in header.strip().split(",")


def laid_back(trajectory, device):
    """Options of the replay device that take a recording back there; of others none. ValueError is a line."""
    if not is_recording(trajectory):
        return ""
    if device.get("orientation_xyzw", [0.0, 0.0, 0.0, 1.0])[:3] != [0.0, 0.0, 0.0]:
        raise ValueError(f"{trajectory}: recorded where [device] is turned: expected a trajectory of the device, as no "
                         "recording replays in place there")
    scale = device.get("scale", 1.0)
    at_m = zip("xyz", device.get("position_m", ()))
    return ",".join([f"scale={1.0 / scale!r}"] * (scale != 1.0)
                    + [f"offset_{axis}_m={-x_m / scale!r}" for axis, x_m in at_m if x_m])
