"""The same markers through the frames of a burst.

Each frame's blobs are matched to the markers followed so far by nearness; a living patient sways by
a pixel or two in that time. A marker is kept if enough frames show it, which removes what flickers.
What differs so little from its surround that noise hides it in the frames is seen in their mean.
"""

import math
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

    def gate_px_of(self, radius_px: float) -> float:
        """Return how far a marker moves at most between two sightings."""
        return max(self.gate_px, 2.0 * radius_px)

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
        Frames that show it; all of them where their mean does.
    is_faint : bool
        In most of its sightings: see `Blob`.
    """

    u: float
    v: float
    radius_px: float
    axis_ratio: float
    covariance_px2: FloatArray
    n_sightings: int
    is_faint: bool


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
                if distance_px[i, j] <= self._params.gate_px_of(blobs[j].radius_px):
                    self._tracks[i].append(blobs[j])
                    taken.add(j)
        self._tracks += [[blob] for j, blob in enumerate(blobs) if j not in taken]

    def markers(self, of_mean: Sequence[Blob] = ()) -> tuple[BurstMarker, ...]:
        """Return what enough frames show, from top to bottom.

        Parameters
        ----------
        of_mean : sequence of Blob
            Found in the mean picture of all frames: those that are none of the followed ones are
            markers, too.
        """
        least = max(1.0, self._params.least_share * self._n_frames)
        kept = [track for track in self._tracks if len(track) >= least]
        found = [_fused(track, self._params) for track in kept]
        for blob in of_mean:
            if all(self._is_apart(blob, marker) for marker in found):
                found.append(_still(blob, self._n_frames, self._params))
        return tuple(sorted(found, key=lambda marker: (marker.v, marker.u)))

    def _is_apart(self, blob: Blob, marker: BurstMarker) -> bool:
        distance_px = math.hypot(blob.u - marker.u, blob.v - marker.v)
        return distance_px > self._params.gate_px_of(blob.radius_px)


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
    return BurstMarker(
        u=float(u),
        v=float(v),
        radius_px=radius_px,
        axis_ratio=float(np.median([blob.axis_ratio for blob in track])),
        covariance_px2=mean_covariance / n_samples + _lasting(radius_px, params),
        n_sightings=len(track),
        is_faint=2 * sum(blob.is_faint for blob in track) > len(track),
    )


def _still(blob: Blob, n_frames: int, params: BurstParams) -> BurstMarker:
    """Return the marker that the mean picture shows; its noise is already that of the mean."""
    return BurstMarker(
        u=blob.u,
        v=blob.v,
        radius_px=blob.radius_px,
        axis_ratio=blob.axis_ratio,
        covariance_px2=blob.covariance_px2 + _lasting(blob.radius_px, params),
        n_sightings=n_frames,
        is_faint=blob.is_faint,
    )


def _lasting(radius_px: float, params: BurstParams) -> FloatArray:
    return np.eye(2) * params.centre_variance_px2(radius_px)
