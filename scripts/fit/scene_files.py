"""The scene of a fit: copied with all that it reads into the fit's folder, and written anew as fitted."""
import filecmp
import os
import pathlib
import shutil
import tomllib

import recorded_frame
import toml_edit
from runs import Unusable, hash_of


class SceneFiles:
    """folder/inputs holds copies, so that a run reads nothing else and may go to another machine."""

    def __init__(self, scene, folder):
        self.scene, self.folder, self.inputs = scene, folder, folder / "inputs"
        self.inputs.mkdir(parents=True, exist_ok=True)
        try:
            self.text = scene.read_bytes().decode("utf-8")  # with its line ends
            self.document = tomllib.loads(self.text)
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise Unusable(f"{scene}: {error}") from error
        self.needed = []  # copies, relative to the folder
        self.read = {}  # path in the document: the user's file
        self.copied = self._copy_scene()

    def _copy_scene(self):
        bodies = self.document.get("body", [])
        if not isinstance(bodies, list) or not all(isinstance(body, dict) for body in bodies):
            raise Unusable(f"{self.scene}: body: expected [[body]] tables")
        changes = {}
        for i, body in enumerate(bodies):
            spheres = body.get("spheres")
            for path, table in ((("body", i, "file"), body), (("body", i, "spheres", "file"), spheres)):
                name = table.get("file") if isinstance(table, dict) else None
                if isinstance(name, str) and (self.scene.parent / name).is_file():
                    self.read[path] = self.scene.parent / name
                    changes[path] = self.copy(self.scene.parent / name).name
                    self.needed.append(f"inputs/{changes[path]}")
        if self.hand and self.hand.is_file():
            self.read["hand", "file"] = self.hand
            changes["hand", "file"] = self.copy(self.hand).name
        copied = self.inputs / self.scene.name
        text = self.edited(changes)
        if not copied.is_file() or copied.read_bytes() != text.encode():
            copied.write_bytes(text.encode())
        self.needed.append(f"inputs/{copied.name}")
        return tomllib.loads(text)

    @property
    def hand(self):
        """The trajectory that the scene names as its own, or nothing."""
        hand = self.document.get("hand")
        name = hand.get("file") if isinstance(hand, dict) else None
        return self.scene.parent / name if isinstance(name, str) else None

    def copy(self, file):
        """The copy of a file, under its name or, where another has that, one with its hash."""
        copy = self.inputs / file.name
        if copy.exists() and not filecmp.cmp(file, copy, shallow=False):
            copy = self.inputs / f"{file.stem}_{hash_of(file)[:8]}{file.suffix}"
        if not copy.exists():
            part = copy.with_name(copy.name + ".part")
            shutil.copyfile(file, part)
            part.replace(copy)
        return copy

    def laid_back(self, trajectory):
        """Options of the replay device for a recording of haptic_server, which is in the scene's frame; else none."""
        try:
            return recorded_frame.laid_back(trajectory, self.document.get("device", {}))
        except ValueError as error:
            raise Unusable(error) from None

    def edited(self, changes):
        changes = dict(changes)
        renamed = []
        simulation = self.document.get("simulation", {})
        if ("simulation", "rate_hz") in changes and "period_s" in simulation:
            renamed.append((("simulation", "period_s"), "rate_hz"))
        try:
            return toml_edit.edited(self.text, changes, renamed)
        except toml_edit.Exotic as error:
            raise Unusable(f"{self.scene}: {error}: expected keys and tables that can be edited safely") from error

    def fitted_text(self, changes, head):
        """The user's text with these changes of the copied scene, to stand in the fit's folder."""
        all_changes = {path: os.path.relpath(file, self.folder) for path, file in self.read.items()}
        for path, value in changes.items():
            if path[-1] == "spheres" and "file" in value:
                value = {**value, "file": f"inputs/{value['file']}"}
                all_changes.pop((*path, "file"), None)
            all_changes[path] = value
        comment = [f"# {line}".rstrip() for line in head]
        return toml_edit.line_end_of(self.text).join([*comment, "", self.edited(all_changes)])

    @property
    def fitted(self):
        return self.folder / f"{self.scene.stem}_fitted.toml"


def find_scene(name, here):
    """A file, or the name of a scene that ships."""
    shipped = (here.parent / "sim_server/scene/scenes", here.parent / "share/stillgrid/scenes")
    candidates = [pathlib.Path(name), *(folder / f"{name}.toml" for folder in shipped)]
    scene = next((file for file in candidates if file.is_file()), None)
    if scene is None:
        raise Unusable(f"{name}: no such scene: expected a file, or the name of a scene that ships")
    return scene.resolve()
