"""Intrinsics and poses in closed form from homographies of a plane, without distortion.

A homography of a plane is K (r1 r2 t) up to scale; r1 and r2 are of one length and at a right
angle, so that each view gives two linear equations for the six numbers of B = K^-T K^-1.

Source: Zhang, A flexible new technique for camera calibration, PAMI 22 (2000), section 3.1 and
appendix B; thesis, equations 4.11-4.14.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from adibas.arrays import FloatArray, check_shape
from adibas.geometry.rigid import RigidTransform

VIEWS_WITH_SKEW = 3
VIEWS_WITHOUT_SKEW = 2
# Focal lengths of real lenses, in image sides: a view of 157 down to 6 degrees.
SHORTEST_FOCAL = 0.1
LONGEST_FOCAL = 10.0
FARTHEST_CENTRE = 0.75
"""Of the principal point from the middle of the image, in its sides."""

MOST_SKEW = 0.2


class Assumption(Enum):
    """What had to be assumed because the views do not tell."""

    NOTHING = "nothing"
    NO_SKEW = "no skew"
    CENTRED = "no skew, and the principal point in the middle of the image"
    NOMINAL = "focal length of one image side, and the principal point in the middle"


@dataclass(frozen=True, slots=True, eq=False)
class ClosedForm:
    """A camera without distortion.

    Attributes
    ----------
    matrix : (3, 3) array
        K with skew, pixels (equation 4.11).
    assumption : Assumption
        What the views left open.
    """

    matrix: FloatArray
    assumption: Assumption


def closed_forms(
    homographies: Sequence[FloatArray], size: tuple[int, int]
) -> tuple[ClosedForm, ...]:
    """Return every plausible camera, the one with the fewest assumptions first.

    Parameters
    ----------
    homographies : sequence of (3, 3) arrays
        From the board's plane into pixels.
    size : (height, width)
        Of the images.

    Returns
    -------
    cameras : tuple of ClosedForm
        Never empty: the last one assumes everything. Views that are few or alike (all frontal,
        say) make the first ones imaginary, or no camera at all; they are then left out.
    """
    height, width = size
    side = 0.5 * (width + height)
    centre = np.array([0.5 * (width - 1), 0.5 * (height - 1)])
    into_unit = np.array(
        [
            [1.0 / side, 0.0, -centre[0] / side],
            [0.0, 1.0 / side, -centre[1] / side],
            [0.0, 0.0, 1.0],
        ]
    )
    rows = _equations([into_unit @ homography for homography in homographies])
    wanted = [(Assumption.CENTRED, [0, 2, 5])]
    if len(homographies) >= VIEWS_WITHOUT_SKEW:
        wanted.insert(0, (Assumption.NO_SKEW, [0, 2, 3, 4, 5]))
    if len(homographies) >= VIEWS_WITH_SKEW:
        wanted.insert(0, (Assumption.NOTHING, [0, 1, 2, 3, 4, 5]))
    found = []
    for assumption, unknowns in wanted:
        unit = _matrix(rows, unknowns)
        if unit is not None and _is_plausible(unit):
            found.append(ClosedForm(np.linalg.solve(into_unit, unit), assumption))
    found.append(ClosedForm(np.linalg.inv(into_unit), Assumption.NOMINAL))
    return tuple(found)


def pose_from_homography(homography: FloatArray, matrix: FloatArray) -> RigidTransform:
    """Return ``camera_from_board``.

    Parameters
    ----------
    homography : (3, 3) array
        From the board's (x, y) in metres into pixels, its last row positive at the points.
    matrix : (3, 3) array
        K.
    """
    check_shape("homography", homography, (3, 3))
    columns = np.linalg.solve(matrix, homography)
    columns /= 0.5 * (np.linalg.norm(columns[:, 0]) + np.linalg.norm(columns[:, 1]))
    first, second, translation_m = columns.T
    left, _, right = np.linalg.svd(np.stack([first, second, np.cross(first, second)], axis=1))
    return RigidTransform(left @ right, translation_m)


def _equations(homographies: Sequence[FloatArray]) -> FloatArray:
    """Return the (2 n, 6) rows for B11, B12, B22, B13, B23, B33."""
    rows = []
    for homography in homographies:
        first, second = homography[:, 0], homography[:, 1]
        length = np.linalg.norm(homography)
        rows += [
            _row(first, second) / length**2,
            (_row(first, first) - _row(second, second)) / length**2,
        ]
    return np.array(rows).reshape(-1, 6)


def _row(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.array(
        [
            a[0] * b[0],
            a[0] * b[1] + a[1] * b[0],
            a[1] * b[1],
            a[2] * b[0] + a[0] * b[2],
            a[2] * b[1] + a[1] * b[2],
            a[2] * b[2],
        ]
    )


def _matrix(rows: FloatArray, unknowns: list[int]) -> FloatArray | None:
    """Return K of the B that fulfils the equations best; None where that B has no real K."""
    b = np.zeros(6)
    b[unknowns] = np.linalg.svd(rows[:, unknowns])[2][-1]
    B = np.array([[b[0], b[1], b[3]], [b[1], b[2], b[4]], [b[3], b[4], b[5]]])  # noqa: N806
    B *= np.sign(b[0]) or 1.0  # noqa: N806
    try:
        lower = np.linalg.cholesky(B)
    except np.linalg.LinAlgError:
        return None
    # B = L L' = K^-T K^-1, so that K^-T is L up to scale.
    matrix = np.linalg.inv(lower.T)
    return np.asarray(matrix / matrix[2, 2])


def _is_plausible(unit: FloatArray) -> bool:
    """Say whether K in units of the image's side may be that of a lens."""
    focal = np.array([unit[0, 0], unit[1, 1]])
    return bool(
        (focal > SHORTEST_FOCAL).all()
        and (focal < LONGEST_FOCAL).all()
        and focal.max() < 2.0 * focal.min()
        and (np.abs(unit[:2, 2]) < FARTHEST_CENTRE).all()
        and abs(unit[0, 1]) < MOST_SKEW * focal[0]
    )
