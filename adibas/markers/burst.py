"""The same markers through the frames of a burst.

Each frame's blobs are matched to the markers followed so far by nearness; a living patient sways by
a pixel or two in that time. A marker is kept if enough frames show it, which removes what flickers.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from adibas.arrays import FloatArray
from adibas.data.markers import pixels_uv
from adibas.markers.blobs import Blob

FAR_PX = 1e3
"""All distances beyond are alike, so that one stray blob cannot spoil the matching of the rest."""


@dataclass(frozen=True, slots=True)
class BurstParams:
    """How blobs become markers.

    Attributes
    ----------
    gate_px : float
        Farthest that a marker moves between two sightings, at least; or its diameter if larger.
    least_share : float
        A marker is seen in this share of the frames: 0.5.
    frames_per_sample : float
        The sway moves all frames alike; so many count as one: 3.
    centre_sd_px, centre_sd_by_radius_px2 : float
        What no number of frames takes out of a centre: shading, foreshortening, what stands beside
        it: 0.045 pixels, and 0.14 square pixels by the radius. As measured on 1,715
        simulated markers that are 2.5 to 16 pixels wide (docs/benchmarks.md).
    """

    gate_px: float = 5.0
    least_share: float = 0.5
    frames_per_sample: float = 3.0
    centre_sd_px: float = 0.045
    centre_sd_by_radius_px2: float = 0.14

    def centre_variance_px2(self, radius_px: float) -> float:
        """Return the variance of a centre, along each axis, that all frames have in common."""
        return self.centre_sd_px**2 + (self.centre_sd_by_radius_px2 / radius_px) ** 2


@dataclass(frozen=True, slots=True, eq=False)
class BurstMarker:
    """One marker of a burst.

    Attributes
    ----------
    u, v, radius_px : float
        Means over the frames that show it, without outliers.
    axis_ratio : float
        Short over long axis: the median.
    covariance_px2 : (2, 2) array
        Of (u, v).
    n_sightings : int
        Frames that show it.
    """

    u: float
    v: float
    radius_px: float
    axis_ratio: float
    covariance_px2: FloatArray
    n_sightings: int


class BurstTracker:
    """Collects the blobs of one frame after the other."""

    def __init__(self, params: BurstParams) -> None:
        self._params = params
        self._tracks: list[list[Blob]] = []
        self._n_frames = 0

    def add(self, blobs: Sequence[Blob]) -> None:
        """Add the blobs of the next frame."""
        self._n_frames += 1
        known = len(self._tracks)
        taken: set[int] = set()
        if known and blobs:
            last = pixels_uv(track[-1] for track in self._tracks)
            here = pixels_uv(blobs)
            distance_px = np.linalg.norm(last[:, None] - here, axis=2)
            rows, columns = linear_sum_assignment(np.minimum(distance_px, FAR_PX))
            for i, j in zip(rows.tolist(), columns.tolist(), strict=True):
                gate_px = max(self._params.gate_px, 2.0 * blobs[j].radius_px)
                if distance_px[i, j] <= gate_px:
                    self._tracks[i].append(blobs[j])
                    taken.add(j)
        self._tracks += [[blob] for j, blob in enumerate(blobs) if j not in taken]

    def markers(self) -> tuple[BurstMarker, ...]:
        """Return what enough frames show, from top to bottom."""
        least = max(1.0, self._params.least_share * self._n_frames)
        kept = [track for track in self._tracks if len(track) >= least]
        found = [_fused(track, self._params) for track in kept]
        return tuple(sorted(found, key=lambda marker: (marker.v, marker.u)))


def _fused(track: Sequence[Blob], params: BurstParams) -> BurstMarker:
    """Average a track's centres, leaving out those far from the median."""
    centres = pixels_uv(track)
    deviation = np.linalg.norm(centres - np.median(centres, axis=0), axis=1)
    limit = 3.0 * max(1.4826 * float(np.median(deviation)), 0.1)
    kept = deviation <= limit
    mean_covariance = np.mean([blob.covariance_px2 for blob in track], axis=0)
    n_samples = max(1.0, float(kept.sum()) / params.frames_per_sample)
    u, v = centres[kept].mean(axis=0)
    radius_px = float(np.median([blob.radius_px for blob in track]))
    lasting = np.eye(2) * params.centre_variance_px2(radius_px)
    return BurstMarker(
        u=float(u),
        v=float(v),
        radius_px=radius_px,
        axis_ratio=float(np.median([blob.axis_ratio for blob in track])),
        covariance_px2=mean_covariance / n_samples + lasting,
        n_sightings=len(track),
    )
