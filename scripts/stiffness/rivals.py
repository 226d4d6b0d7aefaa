"""What spheres predict of a recording: each model as stiff as suits the first recording best, on the fitted surface."""
from fit_scene import PROBE_N_PER_M

RIVALS = (("even spheres", lambda scene: {"spheres": {"surface_spacing_m": 0.8 * scene.tool_m}}),
          ("decomposition", lambda scene: {"spheres": {"tolerance_m": 0.2 * scene.tool_m}}))


class Spheres:
    """contact: keys of the body; the tool is larger by the offset, for spheres have none of their own."""

    def __init__(self, name, contact, ruler, track, fit):
        self.name = name
        self.text = ruler.scene.alone(contact, ruler.scene.tool_m + fit.offset_m)
        self.track, self.stiffness_scale, self.first_N = track, 1.0, None
        self.first_N = self.forces_N(ruler, track)
        touched = track.touched(fit.offset_m)
        pressed_N = track.along(self.first_N)[touched]
        square = pressed_N @ pressed_N
        self.stiffness_scale = pressed_N @ track.contact.force_N[touched] / square if square > 0.0 else 0.0

    @property
    def stiffness_N_per_m(self):
        return self.stiffness_scale * PROBE_N_PER_M

    def forces_N(self, ruler, track):
        """At all rows of a recording; a force is linear in the stiffness."""
        if track is self.track and self.first_N is not None:
            return self.stiffness_scale * self.first_N
        return self.stiffness_scale * ruler.replay_text(track.recording, self.text)[0]
