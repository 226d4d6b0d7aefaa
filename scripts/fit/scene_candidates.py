"""A scene's text and the ways to simulate and show it, as changes of that text."""
import dataclasses
import os
import tomllib

import levels
import messages
import toml_edit

METHODS = (None, ("velocity_verlet", None), ("implicit_euler", 1), ("implicit_euler", 2))  # none: as given
METHOD_KEYS = ("integrator", "substeps", "tolerance_m_s")


@dataclasses.dataclass(frozen=True)
class Candidate:
    """One way to simulate and to show a scene."""
    rate_hz: float
    transition: str = "local"  # the default of haptic_server
    method: tuple | None = None
    levels: tuple = ()  # of each group of bodies

    def but(self, **changes):
        return dataclasses.replace(self, **changes)


class Scene:
    """The scene's text, and its candidates as changes of it."""

    def __init__(self, file):
        self.file = file
        try:
            self.text = file.read_bytes().decode("utf-8")
            self.document = tomllib.loads(self.text)
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise messages.Unusable(f"{file}: {error}") from error
        if isinstance(self.document.get("hand"), list):
            raise messages.Unusable(f"{file}: hand: value {len(self.document['hand'])} hands with names: expected the tables "
                           "[tool] and [device] of one")
        self.simulation = self.document.get("simulation", {})
        self.groups = levels.groups_of(self.document, messages.note)
        self.places = {body["name"]: i for i, body in enumerate(self.document.get("body", []))}
        hz = self.simulation.get("rate_hz", 1.0 / self.simulation.get("period_s", 0.01))
        self.given = Candidate(float(hz), levels=(0,) * len(self.groups),
                               method=METHODS[1] if self.simulation.get("integrator") == "auto" else None)

    def changes(self, candidate):
        """Paths of toml_edit, and values."""
        changes = {}
        if candidate.rate_hz != self.given.rate_hz:
            changes["simulation", "rate_hz"] = candidate.rate_hz
        if candidate.method:
            changes.update({("simulation", key): None for key in METHOD_KEYS if key in self.simulation})
            changes["simulation", "integrator"], substeps = candidate.method
            if substeps:
                changes["simulation", "substeps"] = substeps
        for (names, group), level in zip(self.groups, candidate.levels):
            for name in names:
                changes.update({("body", self.places[name], key): value for key, value in group[level][1].items()})
        return changes

    def text_of(self, candidate, folder, hand=None, settle_s=None, head=()):
        """The scene's text with these changes, to stand in the folder; hand: instead of its own."""
        changes = self.changes(candidate)
        for i, body in enumerate(self.document.get("body", [])):
            for path, table in ((("file",), body), (("spheres", "file"), body.get("spheres", {}))):
                if isinstance(table.get("file"), str):
                    changes["body", i, *path] = os.path.relpath(self.file.parent / table["file"], folder)
        own = self.document.get("hand", {}).get("file")
        if hand or own:
            changes["hand", "file"] = os.path.relpath(hand or self.file.parent / own, folder)
        if settle_s is not None:
            changes["hand", "settle_s"] = settle_s
        is_renamed = ("simulation", "rate_hz") in changes and "period_s" in self.simulation
        try:
            text = toml_edit.edited(self.text, changes, [(("simulation", "period_s"), "rate_hz")] * is_renamed)
        except toml_edit.Exotic as error:
            raise messages.Unusable(f"{self.file}: {error}: expected keys and tables that can be edited safely") from error
        return toml_edit.line_end_of(text).join([*(f"# {line}".rstrip() for line in head), *([""] if head else []),
                                                 text])

    def describe(self, candidate):
        parts = [f"{candidate.rate_hz:g} Hz", candidate.transition]
        if candidate.method:
            parts.append(candidate.method[0] + (f" in {candidate.method[1]} substeps"
                                                if (candidate.method[1] or 1) > 1 else ""))
        parts += [f"{', '.join(names)}: {group[level][0]}"
                  for (names, group), level in zip(self.groups, candidate.levels) if level]
        return ", ".join(parts)
