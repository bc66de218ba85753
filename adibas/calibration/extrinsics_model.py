"""Residuals and derivatives of boards and walls that two cameras see.

Unknown are the pose of the depth camera (a small turn w about the colour camera's axes and a shift
t), the depth bias (a, b, c, image term), and the inverse plane m of every shot. All residuals are
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
from adibas.data.calibration import DepthBias, image_polynomial
from adibas.geometry.rigid import RigidTransform, rotation_from_vector

EXTRINSIC_NAMES = tuple(f"color_from_depth.{name}" for name in ("rx", "ry", "rz", "tx", "ty", "tz"))
"""A small turn about the colour camera's axes (radians), after the rotation, and the shift."""

N_EXTRINSIC = len(EXTRINSIC_NAMES)
SMALLEST_PER_M = 1e-3
SMALLEST_DEPTH_M = 1e-3
SMALLEST_ROOT = 1e-2
"""Where a wild step of the search would ask for the root of a negative number."""


def bias_names(n_terms: int) -> tuple[str, ...]:
    """Return the names of a depth bias with an image term of that length."""
    image = tuple(f"depth_bias.image_term.{number}" for number in range(n_terms))
    return ("depth_bias.a", "depth_bias.b", "depth_bias.c", *image)


@dataclass(frozen=True, slots=True, eq=False)
class DepthState:
    """One guess at everything unknown.

    Attributes
    ----------
    color_from_depth : RigidTransform
        Pose of the depth camera.
    bias : DepthBias
        With an image term of the wanted length.
    planes : (S, 3) array
        Inverse planes; those of boards in the colour camera, those of walls in the depth camera.
    """

    color_from_depth: RigidTransform
    bias: DepthBias
    planes: FloatArray

    def moved(self, step: FloatArray) -> "DepthState":
        """Return the state after a step of all unknowns."""
        turn = rotation_from_vector(step[:3]) @ self.color_from_depth.rotation
        left, _, right = np.linalg.svd(turn)
        n_bias = 3 + len(self.bias.image_term)
        by_bias = step[N_EXTRINSIC : N_EXTRINSIC + n_bias]
        planes = step[N_EXTRINSIC + n_bias :].reshape(-1, N_PLANE)
        return DepthState(
            RigidTransform(left @ right, self.color_from_depth.translation_m + step[3:6]),
            moved_bias(self.bias, by_bias),
            self.planes + planes,
        )


def bias_numbers(bias: DepthBias) -> FloatArray:
    """Return a, b, c and the image term as one (3 + n,) array."""
    return np.array([bias.a, bias.b, bias.c, *bias.image_term])


def moved_bias(bias: DepthBias, step: FloatArray) -> DepthBias:
    """Return the bias after a (3 + n,) step of a, b, c and the image term."""
    a, b, c, *image = (bias_numbers(bias) + step).tolist()
    return DepthBias(a, b, c, tuple(image))


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
    by_global : (N, 6 + 3 + n) array
        By pose and bias.
    by_plane : (N, 3) array
        By the shot's own plane.
    """

    residuals: FloatArray
    by_global: FloatArray
    by_plane: FloatArray


def corrected_inverse(cells: Cells, bias: DepthBias) -> FloatArray:
    """Return the (N,) corrected 1/z of cells."""
    z_m = 1.0 / cells.inverse_m
    return np.asarray(1.0 / (_bias_terms(cells, z_m, bias) @ bias_numbers(bias)))


def measured_inverse(
    cells: Cells, true_per_m: FloatArray, bias: DepthBias
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return what a device with this bias measures.

    Returns
    -------
    measured_per_m, by_true : (N,) arrays
        1/z and its derivative by the true one.
    by_bias : (N, 3 + n) array
        By a, b, c and the image term.
    """
    true_m = 1.0 / np.maximum(true_per_m, SMALLEST_PER_M)
    image = image_polynomial(cells.places[:, 0], cells.places[:, 1], len(bias.image_term))
    square = bias.c + sum((f * t for f, t in zip(bias.image_term, image, strict=True)), start=0.0)
    # The device measures z where truth = a + b z + square z^2.
    excess_m = np.maximum(true_m - bias.a, SMALLEST_DEPTH_M)
    root = np.sqrt(np.maximum(bias.b**2 + 4.0 * square * excess_m, SMALLEST_ROOT))
    z_m = 2.0 * excess_m / (bias.b + root)
    terms = _bias_terms(cells, z_m, bias)
    # And `root` is the slope of the truth by z there.
    return (
        1.0 / z_m,
        (true_m / z_m) ** 2 / root,
        terms / (z_m**2 * root)[:, None],
    )


def _bias_terms(cells: Cells, z_m: FloatArray, bias: DepthBias) -> FloatArray:
    """Return the (N, 3 + n) factors of a, b, c and the image term at measured depths."""
    image = image_polynomial(cells.places[:, 0], cells.places[:, 1], len(bias.image_term))
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
    return _rows(cells, in_depth, (by_pose, by_plane), state.bias)


def wall_rows(cells: Cells, m: FloatArray, state: DepthState) -> Rows:
    """Return the rows of a wall whose inverse plane in the depth camera is `m`."""
    return _rows(cells, m, (np.zeros((N_PLANE, N_EXTRINSIC)), np.eye(N_PLANE)), state.bias)


def _rows(
    cells: Cells, in_depth: FloatArray, by: tuple[FloatArray, FloatArray], bias: DepthBias
) -> Rows:
    """Return the rows of an inverse plane in the depth camera that goes with pose and plane."""
    rays = np.column_stack([cells.rays, np.ones(len(cells))])
    measured, by_true, by_bias = measured_inverse(cells, rays @ in_depth, bias)
    by_in_depth = -by_true[:, None] * rays
    by_pose, by_plane = by
    return Rows(
        cells.inverse_m - measured,
        np.concatenate([by_in_depth @ by_pose, -by_bias], axis=1),
        by_in_depth @ by_plane,
    )


class Prior(NamedTuple):
    """What is known beforehand: a mean and the information (inverse covariance) of it."""

    mean: FloatArray
    information: FloatArray


def plane_priors(planes: Sequence[InversePlane], variance: float) -> list[Prior]:
    """Return what the colour camera knows of the planes; `variance` scales its own account."""
    return [
        Prior(plane.m, np.asarray(np.linalg.inv(plane.covariance * variance))) for plane in planes
    ]
