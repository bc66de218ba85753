"""How high the crown is, which a sensor below it does not see.

The last place that is seen lies where the look touches the head. Of a sphere of radius R, at which
the look rises by an angle e, that is R (1 - cos e) below the top. Of the head's outline a rim is
missing, as at every edge of the depth; it grows as the depth's error does, with the square of the
distance.
"""

import math

from adibas.arrays import FloatArray
from adibas.geometry.rigid import RigidTransform

CROWN_RADIUS_M = 0.209
RIM_PX_PER_M = 1.13
"""Fitted to four views each of 36 simulated people of 1.50 to 1.86 m: 24 of seeds 4200-4223 with
the sensor 1 m over the floor and 2 m away, six each of 4230-4235, 1.4 m and 2 m, and 4236-4241, 1 m
and 2.7 m. The medians of four views then err by 0.9, 0.2 and -0.8 mm in the mean, and scatter by
1.2, 1.4 and 4.1."""


def crown_height_m(patient_m: FloatArray, axes: RigidTransform, focal_px: float) -> float:
    """Return the height of the crown over the floor.

    Parameters
    ----------
    patient_m : (N, 3) array
        What one view sees of somebody whose head is whole in the picture; patient axes, y up from
        the floor.
    axes : RigidTransform
        From the camera to the patient.
    focal_px : float
        Of the camera.
    """
    top_m = patient_m[int(patient_m[:, 1].argmax())]
    right_m, rise_m, ahead_m = (top_m - axes.translation_m).tolist()
    away_m = math.hypot(right_m, ahead_m)
    if rise_m <= 0.0:
        return float(top_m[1])  # from above the crown is seen
    hidden_m = CROWN_RADIUS_M * (1.0 - away_m / math.hypot(away_m, rise_m))
    return float(top_m[1]) + hidden_m + RIM_PX_PER_M * away_m**2 / focal_px
