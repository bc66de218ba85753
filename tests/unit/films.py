"""Recordings of a simulated patient with LEDs on the joints, and what is true of them."""

from adibas.data.joints import JOINT_NAMES
from adibas.recordings import create_recording
from adibas.simulation.patient import MarkerSettings
from adibas.simulation.scenes import open_scene

BENT = range(22, 58, 2)
"""Frames of a bend that is seed 7's: from upright down, and on the way back."""


def patient_with_leds(view="anterior", **changes):
    """Return the scene of somebody with an LED on each joint."""
    markers = MarkerSettings(JOINT_NAMES, kind="led", diameter_m=0.005)
    return open_scene(
        f"{view}_led", markers=markers, color_size=(480, 640), distance_m=2.8, **changes
    )


def filmed(path, frames, view="anterior", **changes):
    """Record frames of a simulated patient; return what is true of the markers in each."""
    scene = patient_with_leds(view, **changes)
    truth = []
    with create_recording(path, scene.info) as writer:
        for index in frames:
            simulated = scene.frame(index)
            writer.write(simulated.sensor_frame)
            truth.append({one.name: one for one in simulated.truth.markers})
    return truth
