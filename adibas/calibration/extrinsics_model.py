"""Residuals and derivatives of boards and walls that two cameras see.

Unknown are the pose of the depth camera (a small turn w about the colour camera's axes and a shift
t), the depth bias (a, b, c, image term), perhaps focal lengths and principal point of the depth
camera, and the inverse plane m of every shot. All residuals are
in measured 1/z, where the depth noise is constant: from the true plane follows what the device
measures. (Corrected depth minus truth would put the noise into the derivatives by the bias, and
so a systematic error of a standard deviation or two into the result.)

With s = 1 / (1 - m . t) the board's plane is s R' m in the depth camera; from R -> exp(w) R
follow the derivatives s R' [m]x by w, s^2 (R' m) m' by t, and s R' + s^2 (R' m) t' by m.

Source: Zhang & Zhang, Calibration between depth and color sensors for commodity depth cameras,
ICME (2011), for planes seen by both; Herrera, Kannala & Heikkila, PAMI 34 (2012), for depth error
in disparity.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from adibas.arrays import FloatArray
from adibas.calibration.shots import N_PLANE, Cells, InversePlane, moved_plane
from adibas.data.calibration import CameraCalibration, DepthBias, image_polynomial
from adibas.geometry.distortion import undistort_pixels
from adibas.geometry.pinhole import Intrinsics, normalise
from adibas.geometry.rigid import RigidTransform, rotation_from_vector

EXTRINSIC_NAMES = tuple(f"color_from_depth.{name}" for name in ("rx", "ry", "rz", "tx", "ty", "tz"))
"""A small turn about the colour camera's axes (radians), after the rotation, and the shift."""

CAMERA_NAMES = ("depth.fx", "depth.fy", "depth.cx", "depth.cy")
N_EXTRINSIC = len(EXTRINSIC_NAMES)
N_CAMERA = len(CAMERA_NAMES)
SMALLEST_PER_M = 1e-3
SMALLEST_DEPTH_M = 1e-3
SMALLEST_ROOT = 1e-2
"""Where a wild step of the search would ask for the root of a negative number."""


def global_names(n_terms: int) -> tuple[str, ...]:
    """Return the names of all that the shots share, for an image term of that length."""
    image = tuple(f"depth_bias.image_term.{number}" for number in range(n_terms))
    bias = ("depth_bias.a", "depth_bias.b", "depth_bias.c", *image)
    return (*EXTRINSIC_NAMES, *bias, *CAMERA_NAMES)


@dataclass(frozen=True, slots=True, eq=False)
class DepthState:
    """One guess at everything unknown.

    Attributes
    ----------
    color_from_depth : RigidTransform
        Pose of the depth camera.
    bias : DepthBias
        With an image term of the wanted length.
    camera : CameraCalibration
        The depth camera.
    planes : (S, 3) array
        Inverse planes; those of boards in the colour camera, those of walls in the depth camera.
    color_error : (n,) array
        What the colour camera's calibration is wrong by, in likely units.
    """

    color_from_depth: RigidTransform
    bias: DepthBias
    camera: CameraCalibration
    planes: FloatArray
    color_error: FloatArray

    def moved(self, step: FloatArray) -> "DepthState":
        """Return the state after a step of all unknowns."""
        turn = rotation_from_vector(step[:3]) @ self.color_from_depth.rotation
        left, _, right = np.linalg.svd(turn)
        n_bias = 3 + len(self.bias.image_term)
        ends = np.cumsum([N_EXTRINSIC, n_bias, N_CAMERA, len(self.color_error)])
        _, by_bias, by_camera, by_color, planes = np.split(step, ends)
        return DepthState(
            RigidTransform(left @ right, self.color_from_depth.translation_m + step[3:6]),
            moved_bias(self.bias, by_bias),
            moved_camera(self.camera, by_camera),
            self.planes + planes.reshape(-1, N_PLANE),
            self.color_error + by_color,
        )


def bias_numbers(bias: DepthBias) -> FloatArray:
    """Return a, b, c and the image term as one (3 + n,) array."""
    return np.array([bias.a, bias.b, bias.c, *bias.image_term])


def moved_bias(bias: DepthBias, step: FloatArray) -> DepthBias:
    """Return the bias after a (3 + n,) step of a, b, c and the image term."""
    a, b, c, *image = (bias_numbers(bias) + step).tolist()
    return DepthBias(a, b, c, tuple(image))


def camera_numbers(camera: CameraCalibration) -> FloatArray:
    """Return fx, fy, cx, cy."""
    k = camera.intrinsics
    return np.array([k.fx, k.fy, k.cx, k.cy])


def moved_camera(camera: CameraCalibration, step: FloatArray) -> CameraCalibration:
    """Return the camera after a (4,) step of focal lengths and principal point."""
    if not step.any():
        return camera
    return replace(camera, intrinsics=Intrinsics(*(camera_numbers(camera) + step).tolist()))


def with_terms(bias: DepthBias, n_terms: int) -> DepthBias:
    """Return the bias with an image term of that length, filled with zeros or cut."""
    image = (*bias.image_term, *([0.0] * n_terms))[:n_terms]
    return replace(bias, image_term=image)


class Rows(NamedTuple):
    """The cells of one shot.

    Attributes
    ----------
    residuals : (N,) array
        Measured minus expected 1/z, 1/metres.
    by_global : (N, 6 + 3 + n + 4) array
        By pose, bias and camera.
    by_plane : (N, 3) array
        By the shot's own plane.
    """

    residuals: FloatArray
    by_global: FloatArray
    by_plane: FloatArray


def corrected_inverse(cells: Cells, bias: DepthBias, camera: CameraCalibration) -> FloatArray:
    """Return the (N,) corrected 1/z of cells."""
    z_m = 1.0 / cells.inverse_m
    places = normalise(cells.pixels, camera.intrinsics)
    return np.asarray(1.0 / (_bias_terms(places, z_m, bias) @ bias_numbers(bias)))


def rays_of(cells: Cells, camera: CameraCalibration) -> FloatArray:
    """Return the (N, 3) viewing rays (x/z, y/z, 1) of cells in a camera."""
    rays = undistort_pixels(cells.pixels, camera.intrinsics, camera.distortion)
    return np.column_stack([rays, np.ones(len(cells))])


def measured_inverse(
    places: FloatArray, true_per_m: FloatArray, bias: DepthBias
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return what a device with this bias measures.

    Parameters
    ----------
    places : (N, 2) array
        ((u - cx) / fx, (v - cy) / fy).
    true_per_m : (N,) array
        1/z.

    Returns
    -------
    measured_per_m, by_true : (N,) arrays
        1/z and its derivative by the true one.
    by_bias : (N, 3 + n) array
        By a, b, c and the image term.
    """
    true_m = 1.0 / np.maximum(true_per_m, SMALLEST_PER_M)
    image = image_polynomial(places[:, 0], places[:, 1], len(bias.image_term))
    square = bias.c + sum((f * t for f, t in zip(bias.image_term, image, strict=True)), start=0.0)
    # The device measures z where truth = a + b z + square z^2.
    excess_m = np.maximum(true_m - bias.a, SMALLEST_DEPTH_M)
    root = np.sqrt(np.maximum(bias.b**2 + 4.0 * square * excess_m, SMALLEST_ROOT))
    z_m = 2.0 * excess_m / (bias.b + root)
    terms = _bias_terms(places, z_m, bias)
    # And `root` is the slope of the truth by z there.
    return (
        1.0 / z_m,
        (true_m / z_m) ** 2 / root,
        terms / (z_m**2 * root)[:, None],
    )


def _bias_terms(places: FloatArray, z_m: FloatArray, bias: DepthBias) -> FloatArray:
    """Return the (N, 3 + n) factors of a, b, c and the image term at measured depths."""
    image = image_polynomial(places[:, 0], places[:, 1], len(bias.image_term))
    return np.column_stack([np.ones_like(z_m), z_m, z_m**2, *(z_m**2 * t for t in image)])


def board_rows(cells: Cells, m: FloatArray, state: DepthState) -> Rows:
    """Return the rows of a board whose inverse plane in the colour camera is `m`."""
    rotation, shift_m = state.color_from_depth.rotation, state.color_from_depth.translation_m
    scale = 1.0 / (1.0 - float(m @ shift_m))
    turned = rotation.T @ m
    x, y, z = m
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    by_turn = scale * rotation.T @ cross
    by_shift = scale**2 * np.outer(turned, m)
    by_plane = scale * rotation.T + scale**2 * np.outer(turned, shift_m)
    in_depth = moved_plane(m, state.color_from_depth)
    by_pose = np.concatenate([by_turn, by_shift], axis=1)
    return _rows(cells, in_depth, (by_pose, by_plane), state)


def wall_rows(cells: Cells, m: FloatArray, state: DepthState) -> Rows:
    """Return the rows of a wall whose inverse plane in the depth camera is `m`."""
    return _rows(cells, m, (np.zeros((N_PLANE, N_EXTRINSIC)), np.eye(N_PLANE)), state)


def _rows(
    cells: Cells, in_depth: FloatArray, by: tuple[FloatArray, FloatArray], state: DepthState
) -> Rows:
    """Return the rows of an inverse plane in the depth camera that goes with pose and plane."""
    k = state.camera.intrinsics
    rays, places = rays_of(cells, state.camera), normalise(cells.pixels, k)
    measured, by_true, by_bias = measured_inverse(places, rays @ in_depth, state.bias)
    by_in_depth = -by_true[:, None] * rays
    # The lens bends a change of the pixel's place by a few percent, which does not matter to the
    # way down. With the place the image term changes, too.
    bend_x, bend_y = _image_slopes(places, state.bias.image_term)
    across = -(in_depth[0] * by_true + bend_x * by_bias[:, 2]) / k.fx
    along = -(in_depth[1] * by_true + bend_y * by_bias[:, 2]) / k.fy
    by_camera = -np.stack([across * places[:, 0], along * places[:, 1], across, along], axis=-1)
    by_pose, by_plane = by
    return Rows(
        cells.inverse_m - measured,
        np.concatenate([by_in_depth @ by_pose, -by_bias, by_camera], axis=1),
        by_in_depth @ by_plane,
    )


def _image_slopes(
    places: FloatArray, image_term: tuple[float, ...]
) -> tuple[FloatArray, FloatArray]:
    """Return the derivatives of the image term by x and y."""
    x, y = places.T
    none, one = np.zeros_like(x), np.ones_like(x)
    by_x = (one, none, 2 * x, y, none, 3 * x * x, 2 * x * y, y * y, none)
    by_y = (none, one, none, x, 2 * y, none, x * x, 2 * x * y, 3 * y * y)
    return (
        np.asarray(sum((f * t for f, t in zip(image_term, by_x, strict=False)), start=none)),
        np.asarray(sum((f * t for f, t in zip(image_term, by_y, strict=False)), start=none)),
    )


class Prior(NamedTuple):
    """What the colour camera knows of a plane.

    Attributes
    ----------
    mean : (3,) array
        By the camera as it was given.
    information : (3, 3) array
        Inverse covariance of that, by the noise of the corners.
    by_color : (3, n) array
        How it goes with `DepthState.color_error`.
    """

    mean: FloatArray
    information: FloatArray
    by_color: FloatArray


def plane_priors(
    planes: Sequence[InversePlane], variance: float, color_units: FloatArray
) -> list[Prior]:
    """Return what the colour camera knows of the planes.

    `variance` scales its own account of the corners; `color_units` is (17, n).
    """
    return [
        Prior(
            plane.m,
            np.asarray(np.linalg.inv(plane.covariance * variance)),
            plane.by_camera @ color_units,
        )
        for plane in planes
    ]
