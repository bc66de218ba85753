"""The markers of a moving patient, frame by frame, and what the reader must know of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, check_shape
from adibas.body.staying import Moment
from adibas.data.calibration import RgbdCalibration
from adibas.data.frames import RgbdFrame
from adibas.data.sentence import Sentence
from adibas.markers.blobs import Blob
from adibas.markers.disparity import DisparitySum
from adibas.markers.merged import MERGED, MergedParams
from adibas.markers.position import PositionFinder
from adibas.pipeline.frame_notices import counted
from adibas.pipeline.posture import (
    LEAST_WIDTH_PX,
    SEVERAL_PEOPLE,
    TOO_FEW_PIXELS,
    MarkerTarget,
    PostureParams,
    Sight,
    cameras_of,
    check_selective,
    find_markers,
    look_for_person,
)
from adibas.pipeline.posture_checks import NOT_COUNTED, are_two_in_one, count_people

MOVING = MergedParams(least_radius=1.1)
"""A marker that moves fast is drawn long, but not larger; two in one are both."""


@dataclass(frozen=True, slots=True, eq=False)
class FrameMarkers:
    """What one frame shows.

    Attributes
    ----------
    points_m : (N, 3) array
        Of the markers, colour camera, metres; without spots that are two in one.
    n_merged : int
        Such spots.
    n_people : int
        Seen; 0 where nobody is.
    width_px : float
        Of the median marker in the picture; NaN where there is none.
    """

    points_m: FloatArray
    n_merged: int = 0
    n_people: int = 0
    width_px: float = float("nan")

    def __post_init__(self) -> None:
        check_shape("points_m", self.points_m, (None, 3))


def markers_of_frame(
    frame: RgbdFrame,
    calibration: RgbdCalibration,
    target: MarkerTarget,
    params: PostureParams,
    before: Moment | None = None,
) -> tuple[FrameMarkers, Sight | None]:
    """Return the markers of one frame, and who wears them; None where nobody is seen.

    `before`: the person a moment ago; see `see_person`.

    Raises
    ------
    MarkerError
        The colour model fits everything.
    """
    sight = look_for_person(frame, calibration, params, before)
    if sight is None:
        return FrameMarkers(np.empty((0, 3))), None
    detections = find_markers(frame.color_rgb, sight, calibration, target, params)
    check_selective(detections, target, params)
    color, depth = cameras_of(calibration)
    points_m = _located(detections.blobs, frame, calibration, params)
    is_merged = are_two_in_one(detections.blobs, points_m[:, 2], color.intrinsics.fx, MOVING)
    kept_m = points_m[np.isfinite(points_m).all(axis=1) & ~is_merged]
    n_people = count_people(sight.depth_m, depth, sight.floor, sight.body)
    widths_px = [2.0 * blob.radius_px for blob in detections.blobs]
    width_px = float(np.median(widths_px)) if widths_px else float("nan")
    return FrameMarkers(kept_m, int(is_merged.sum()), n_people, width_px), sight


def doubts_about_frames(frames: Sequence[FrameMarkers]) -> tuple[Sentence, ...]:
    """Return what to say of a recording: small markers, other people, and two in one."""
    said: list[tuple[str, int]] = []
    if n_small := sum(one.width_px < LEAST_WIDTH_PX for one in frames):
        said.append((Sentence(TOO_FEW_PIXELS).text, n_small))
    if n_crowded := sum(one.n_people > 1 for one in frames):
        said.append((Sentence(SEVERAL_PEOPLE).text, n_crowded))
    if n_merged := sum(one.n_merged for one in frames):
        told = Sentence(NOT_COUNTED, {"n": n_merged, "reason": MERGED})
        said.append((told.text, sum(one.n_merged > 0 for one in frames)))
    return counted(said, len(frames))


def _located(
    blobs: Sequence[Blob], frame: RgbdFrame, calibration: RgbdCalibration, params: PostureParams
) -> FloatArray:
    """Return (N, 3) positions, colour camera, metres; NaN where the depth is not known."""
    depth = DisparitySum(calibration.depth_bias, calibration.depth)
    depth.add(frame.depth_m)
    disparity = depth.result(params.least_pixel_share, params.greatest_scatter_per_m)
    finder = PositionFinder(disparity, calibration, params.position)
    points_m = np.full((len(blobs), 3), np.nan)
    for row, blob in enumerate(blobs):
        found = finder.locate(np.array([blob.u, blob.v]), blob.covariance_px2)
        if found is not None:
            points_m[row] = found.position_m
    return points_m
