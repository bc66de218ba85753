"""What a calibration of the depth means: intervals, what is badly known, and one calibration.

Source: Hartley & Zisserman, Multiple View Geometry, 2nd ed., section 5.2, for the propagation.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from adibas.arrays import FloatArray
from adibas.calibration.extrinsics import DepthFit
from adibas.calibration.vertical import Vertical
from adibas.data.calibration import CameraCalibration, RgbdCalibration, image_polynomial
from adibas.data.sentence import Sentence
from adibas.geometry.pinhole import normalise
from adibas.geometry.projection import CAMERA_PARAMETERS
from adibas.texts import message

COLOR = "color."
BIAS = ("depth_bias.a", "depth_bias.b", "depth_bias.c")
WEAK_AT_M = 2.0
WEAK_SD_M = 0.01
"""A combination of parameters that leaves 10 mm open at 2 m is worth a word."""

NAMED_SHARE = 0.5
MOST_NAMED = 3

WEAK = message(
    "The pictures do not tell {names} from one another: {error_mm} mm at {distance_m} m stay open. "
    "Add boards that are tilted to each side, near and far, and at the borders of the picture."
)
WEAK_ALONE = message(
    "The pictures tell {names} badly: {error_mm} mm at {distance_m} m stay open. "
    "Add boards that are tilted to each side, near and far, and at the borders of the picture."
)


def camera_slopes(fit: DepthFit, color_names: Sequence[str]) -> FloatArray:
    """Return the (n, m) derivatives of the fit's parameters by the colour camera's.

    Parameters
    ----------
    color_names : sequence of str
        With or without ``color.`` before them; those of other things have no effect.
    """
    slopes = np.zeros((len(fit.parameter_names), len(color_names)))
    for column, name in enumerate(color_names):
        short = name.removeprefix(COLOR)
        if short in CAMERA_PARAMETERS:
            slopes[:, column] = fit.by_camera[:, CAMERA_PARAMETERS.index(short)]
    return slopes


def color_covariance(names: Sequence[str], covariance: FloatArray) -> FloatArray:
    """Return the (17, 17) covariance of the colour camera's `CAMERA_PARAMETERS`; 0 = exact.

    Parameters
    ----------
    names : sequence of str
        Of the (n, n) `covariance`, with or without ``color.``; other things take no part.
    """
    short = [name.removeprefix(COLOR) for name in names]
    known = [index for index, name in enumerate(short) if name in CAMERA_PARAMETERS]
    at = [CAMERA_PARAMETERS.index(short[index]) for index in known]
    whole = np.zeros((len(CAMERA_PARAMETERS),) * 2)
    whole[np.ix_(at, at)] = covariance[np.ix_(known, known)]
    return whole


def camera_covariance(
    fit: DepthFit, color_names: Sequence[str], color_covariance: FloatArray
) -> FloatArray:
    """Return the (n, n) covariance of the fit's parameters, the colour camera's error included."""
    slopes = camera_slopes(fit, color_names)
    return np.asarray(fit.covariance + slopes @ color_covariance @ slopes.T)


def with_depth(
    calibration: RgbdCalibration, fit: DepthFit, vertical: Vertical | None = None
) -> RgbdCalibration:
    """Return the calibration of the whole sensor.

    Parameters
    ----------
    calibration : RgbdCalibration
        Of the colour camera; its covariance is joined with that of the fit. What the fit did not
        estimate keeps the value and the covariance that it had: walls alone do not tell a pose.
    fit : DepthFit
        By that colour camera.
    vertical : Vertical or None
        None leaves gravity and floor as they are.
    """
    names, covariance = _kept_part(calibration, fit)
    slopes = camera_slopes(fit, names)
    n = len(names)
    joint = np.zeros((n + len(fit.parameter_names),) * 2)
    joint[:n, :n] = covariance
    joint[n:, :n] = slopes @ covariance
    joint[:n, n:] = joint[n:, :n].T
    joint[n:, n:] = camera_covariance(fit, names, covariance)
    joined = replace(
        calibration,
        depth=fit.camera,
        color_from_depth=fit.color_from_depth,
        depth_bias=fit.bias,
        parameter_names=(*names, *fit.parameter_names),
        covariance=joint,
    )
    if vertical is None:
        return joined
    return replace(
        joined,
        gravity=np.array(vertical.gravity),
        floor=vertical.floor,
        gravity_sd_rad=vertical.sd_rad,
        floor_flatness_m=None if vertical.floor is None else vertical.flatness_m,
    )


def _kept_part(calibration: RgbdCalibration, fit: DepthFit) -> tuple[tuple[str, ...], FloatArray]:
    """Return names and covariance of what the fit did not estimate; none where unknown."""
    names = calibration.parameter_names
    if calibration.covariance is None:
        return (), np.zeros((0, 0))
    chosen = [index for index, name in enumerate(names) if name not in fit.parameter_names]
    return (
        tuple(names[index] for index in chosen),
        calibration.covariance[np.ix_(chosen, chosen)],
    )


def depth_sd_m(calibration: RgbdCalibration, pixels: FloatArray, depth_m: FloatArray) -> FloatArray:
    """Return how sure the corrected depth is, by the calibration alone.

    Parameters
    ----------
    calibration : RgbdCalibration
        With a covariance of the depth bias; what is not in it counts as exact.
    pixels : (N, 2) array
        (u, v) of the depth camera.
    depth_m : (N,) array
        As measured.

    Returns
    -------
    sd_m : (N,) array
        Standard deviation; the noise of the depth itself comes on top.

    Raises
    ------
    ValueError
        There is no depth camera, or no covariance.
    """
    depth, covariance = calibration.depth, calibration.covariance
    if depth is None or covariance is None:
        raise ValueError("a depth camera and a covariance are needed")
    n_terms = len(calibration.depth_bias.image_term)
    x, y = normalise(pixels, depth.intrinsics).T
    image = image_polynomial(x, y, n_terms)
    factors = np.stack(
        [np.ones_like(depth_m), depth_m, depth_m**2, *(depth_m**2 * term for term in image)]
    )
    names = (*BIAS, *(f"depth_bias.image_term.{number}" for number in range(n_terms)))
    known = [name for name in names if name in calibration.parameter_names]
    at = [calibration.parameter_names.index(name) for name in known]
    slopes = factors[[names.index(name) for name in known]]
    part = covariance[np.ix_(at, at)]
    variances = np.einsum("in,ij,jn->n", slopes, part, slopes)
    return np.asarray(np.sqrt(np.maximum(variances, 0.0)))


def weak_directions(fit: DepthFit, covariance: FloatArray) -> tuple[Sentence, ...]:
    """Name what the boards leave open, the worst first.

    Parameters
    ----------
    fit : DepthFit
        Whose parameters they are.
    covariance : (n, n) array
        Of these; see `camera_covariance`.
    """
    effects = np.array([_effect_m(name, fit.camera) for name in fit.parameter_names])
    variances, axes = np.linalg.eigh(covariance * np.outer(effects, effects))
    sentences = []
    for index in np.argsort(-variances):
        sd_m = float(np.sqrt(max(variances[index], 0.0)))
        if sd_m < WEAK_SD_M:
            break
        loads = np.abs(axes[:, index])
        order = [i for i in np.argsort(-loads) if loads[i] >= NAMED_SHARE * loads.max()]
        names = [fit.parameter_names[i] for i in order[:MOST_NAMED]]
        fields = {
            "names": ", ".join(names),
            "error_mm": 1000.0 * sd_m,
            "distance_m": WEAK_AT_M,
        }
        sentences.append(Sentence(WEAK_ALONE if len(names) == 1 else WEAK, fields))
    return tuple(sentences)


def _effect_m(name: str, camera: CameraCalibration) -> float:
    """Return what a parameter's change by one does to a point at 2 m, about, in metres."""
    z_m = WEAK_AT_M
    half = 0.5 * camera.width / camera.intrinsics.fx
    group, _, last = name.partition(".")
    if group == "depth":
        share = half if last in ("fx", "fy") else 1.0
        return z_m * share / camera.intrinsics.fx
    if group == "color_from_depth":
        return z_m if last.startswith("r") else 1.0
    powers = {"a": 1.0, "b": z_m, "c": z_m**2}
    if last in powers:
        return powers[last]
    number = int(last.rpartition(".")[2])
    degree = 1 if number < 2 else 2 if number < 5 else 3  # noqa: PLR2004  (lengths of the terms)
    return float(z_m**2 * half**degree)
