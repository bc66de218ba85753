"""What a calibration of the depth means: intervals, directions that are badly known, and joining.

Source: Hartley & Zisserman, Multiple View Geometry, 2nd ed., section 5.2, for the propagation.
"""

from collections.abc import Sequence

import numpy as np

from adibas.arrays import FloatArray
from adibas.calibration.extrinsics import DepthFit
from adibas.geometry.projection import CAMERA_PARAMETERS


def camera_slopes(fit: DepthFit, color_names: Sequence[str]) -> FloatArray:
    """Return the (n, m) derivatives of the fit's parameters by the colour camera's.

    Parameters
    ----------
    color_names : sequence of str
        With or without ``color.`` before them; those of other things have no effect.
    """
    slopes = np.zeros((len(fit.parameter_names), len(color_names)))
    for column, name in enumerate(color_names):
        short = name.removeprefix("color.")
        if short in CAMERA_PARAMETERS:
            slopes[:, column] = fit.by_camera[:, CAMERA_PARAMETERS.index(short)]
    return slopes


def camera_covariance(
    fit: DepthFit, color_names: Sequence[str], color_covariance: FloatArray
) -> FloatArray:
    """Return the (n, n) covariance of the fit's parameters, the colour camera's error included."""
    slopes = camera_slopes(fit, color_names)
    return np.asarray(fit.covariance + slopes @ color_covariance @ slopes.T)
