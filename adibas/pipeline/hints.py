"""What the clinician should do so that the whole patient can be measured."""

import numpy as np

from adibas.arrays import BoolArray, Float32Array, FloatArray
from adibas.body.absence import Absence
from adibas.limbs.judging import ABSENCES
from adibas.pipeline.outline import BORDER_PX
from adibas.texts import Message, message

NEAREST_M, FARTHEST_M = 0.8, 4.0
"""Where the sensors of this family measure well."""

SIDE_SHARE = 0.1
"""Of the picture's height: a hand held out of the picture is no side."""
MOST_HOLES = 0.3
"""Of the patient's pixels."""

TOO_NEAR = message("Too near: the patient should stand at least 0.8 m from the sensor.")
TOO_FAR = message("Too far: the patient should stand at most 4 m from the sensor.")
FEET_CUT_OFF = message("The feet are outside the depth picture.")
HEAD_CUT_OFF = message("The head is outside the depth picture.")
SIDE_CUT_OFF = message("A side of the patient is outside the depth picture.")
HOLES = message("Much of the patient has no depth: avoid sunlight, and dark or shiny clothes.")
NOBODY = message("Nobody is seen.")
NO_CALIBRATION = message("This source has no calibration that fits it: nothing can be measured.")
NO_COLOR = message("This frame has no colour picture.")
COLOR_FITS_ALL = message("The learned colour fits too much of the body. Lower the sensitivity.")
TOO_BRIGHT = message("The picture is too bright for LED markers.")


def stance_hints(depth_m: Float32Array, body: BoolArray, up: FloatArray) -> tuple[Message, ...]:
    """Say what is wrong with how the patient stands.

    Parameters
    ----------
    depth_m : (H, W) float32 array
        Metres, NaN where not measured.
    body : (H, W) bool array
        The patient in it.
    up : (3,) array
        Points up, in the depth camera's axes; tells at which side of the picture the feet are.
    """
    distances_m = depth_m[body]
    distances_m = distances_m[np.isfinite(distances_m)]
    hints = [HOLES] * (distances_m.size < (1.0 - MOST_HOLES) * int(np.count_nonzero(body)))
    if distances_m.size:
        distance_m = float(np.median(distances_m))
        hints += [TOO_NEAR] * (distance_m < NEAREST_M) + [TOO_FAR] * (distance_m > FARTHEST_M)
    # Turned so that up is up: the last rows are the lowest.
    quarter_turns = _turns_to_upright(up)
    upright = np.rot90(body, quarter_turns)
    hints += [HEAD_CUT_OFF] * bool(upright[:BORDER_PX].any())
    hints += [FEET_CUT_OFF] * bool(upright[-BORDER_PX:].any())
    sides = (upright[:, :BORDER_PX], upright[:, -BORDER_PX:])
    cut_px = sum(int(side.any(axis=1).sum()) for side in sides)
    hints += [SIDE_CUT_OFF] * (cut_px > SIDE_SHARE * len(upright))
    return tuple(hints)


def absence_hint(absence: Absence) -> Message:
    """Say why nobody is seen, and what to do."""
    own: dict[Absence, Message] = {"near": TOO_NEAR, "nobody": NOBODY}
    return own.get(absence, ABSENCES[absence])


def _turns_to_upright(up: FloatArray) -> int:
    """Return how many quarter turns against the clock bring `up` to the picture's upper side."""
    if abs(up[1]) >= abs(up[0]):
        return 0 if up[1] <= 0 else 2
    return 3 if up[0] < 0 else 1
