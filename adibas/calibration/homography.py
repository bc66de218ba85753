"""The homography from a plane into an image, by the normalised direct linear transform.

Source: thesis, equations 4.6-4.10; Hartley, In defense of the eight-point algorithm, PAMI 19
(1997), for the normalisation; Hartley & Zisserman, Multiple View Geometry, algorithm 4.2, and
section 4.2.3 for the geometric error of the refinement.
"""

import numpy as np

from adibas.arrays import FloatArray, check_shape

LEAST_POINTS = 4
# Smallest but one singular value over the largest, below which the points fix no homography.
DEGENERATE_SHARE = 1e-7
MAX_STEPS = 20
DONE = 1e-10


def fit_homography(
    plane: FloatArray, pixels: FloatArray, *, is_refined: bool = True
) -> FloatArray | None:
    """Find the homography that maps a plane onto an image.

    Parameters
    ----------
    plane : (N, 2) array
        Points of the plane, in any unit.
    pixels : (N, 2) array
        Their images (u, v); rows with a NaN in either are left out.
    is_refined : bool
        Minimise the error in the image after the linear solution.

    Returns
    -------
    homography : (3, 3) array or None
        Scaled to length 1, its last row positive at the points; None for fewer than four points,
        or points that leave it open (all on one line but one, say).
    """
    plane, pixels = np.asarray(plane, float), np.asarray(pixels, float)
    check_shape("plane", plane, (None, 2))
    check_shape("pixels", pixels, plane.shape)
    is_seen = np.isfinite(plane + pixels).all(axis=1)
    plane, pixels = plane[is_seen], pixels[is_seen]
    if len(plane) < LEAST_POINTS:
        return None
    from_plane, from_pixels = _normalisation(plane), _normalisation(pixels)
    if from_plane is None or from_pixels is None:
        return None
    moved_plane, moved_pixels = map_plane(from_plane, plane), map_plane(from_pixels, pixels)
    homography = _linear(moved_plane, moved_pixels)
    if homography is None:
        return None
    if is_refined:
        homography = _refined(homography, moved_plane, moved_pixels)
    found = np.linalg.solve(from_pixels, homography @ from_plane)
    found /= np.linalg.norm(found)
    depths = plane @ found[2, :2] + found[2, 2]
    return np.asarray(found if depths.sum() > 0 else -found)


def map_plane(homography: FloatArray, plane: FloatArray) -> FloatArray:
    """Map (N, 2) points (equation 4.6); infinite or NaN where they map to infinity."""
    u, v, w = homography[:, :2] @ plane.T + homography[:, 2:]
    return np.stack([u / w, v / w], axis=-1)


def _normalisation(points: FloatArray) -> FloatArray | None:
    """Return the similarity that brings the points to mean 0 and mean distance sqrt(2)."""
    centre = points.mean(axis=0)
    distance = np.hypot(*(points - centre).T).mean()
    if not distance > 0:
        return None
    scale = np.sqrt(2.0) / distance
    return np.array(
        [[scale, 0.0, -scale * centre[0]], [0.0, scale, -scale * centre[1]], [0.0, 0.0, 1.0]]
    )


def _linear(plane: FloatArray, pixels: FloatArray) -> FloatArray | None:
    """Solve A h = 0, |h| = 1 (equations 4.8-4.10)."""
    n = len(plane)
    homogeneous = np.concatenate([plane, np.ones((n, 1))], axis=1)
    A = np.zeros((2 * n, 9))  # noqa: N806  (the thesis' letter)
    A[:n, :3] = A[n:, 3:6] = homogeneous
    A[:n, 6:] = -pixels[:, :1] * homogeneous
    A[n:, 6:] = -pixels[:, 1:] * homogeneous
    # The triangle of A has its singular values and is small.
    triangle = np.linalg.qr(A, mode="r") if n > LEAST_POINTS else A
    _, sizes, axes = np.linalg.svd(triangle)
    if not sizes[7] > DEGENERATE_SHARE * sizes[0]:
        return None
    return np.asarray(axes[-1].reshape(3, 3))


def _refined(homography: FloatArray, plane: FloatArray, pixels: FloatArray) -> FloatArray:
    """Minimise the squared distances in the image by Gauss and Newton; a worse step is refused."""
    best, least = homography, ((map_plane(homography, plane) - pixels) ** 2).sum()
    for _ in range(MAX_STEPS):
        step = _step(best, plane, pixels)
        tried = best + step.reshape(3, 3)
        cost = ((map_plane(tried, plane) - pixels) ** 2).sum()
        if not cost < least:
            return best
        is_done = least - cost < DONE * least
        best, least = tried / np.linalg.norm(tried), cost
        if is_done:
            break
    return best


def _step(homography: FloatArray, plane: FloatArray, pixels: FloatArray) -> FloatArray:
    n = len(plane)
    homogeneous = np.concatenate([plane, np.ones((n, 1))], axis=1)
    mapped = map_plane(homography, plane)
    rows = homogeneous / (homogeneous @ homography[2])[:, None]
    J = np.zeros((2, n, 9))  # noqa: N806  (the usual letter)
    J[0, :, :3] = J[1, :, 3:6] = rows
    J[0, :, 6:], J[1, :, 6:] = -mapped[:, :1] * rows, -mapped[:, 1:] * rows
    # The scale of h changes nothing; a row along h keeps the system regular.
    system = np.concatenate([J.reshape(-1, 9), homography.reshape(1, 9)])
    wanted = np.append((pixels - mapped).T.ravel(), 0.0)
    normal = system.T @ system
    return np.asarray(np.linalg.solve(normal, system.T @ wanted))
