"""The result of one posture analysis: everything that a report shows."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import Float32Array, UInt8Array, check_shape, read_only
from adibas.data.calibration import RgbdCalibration
from adibas.data.markers import Marker, RejectedBlob
from adibas.data.measures import AngleMeasure, DistanceMeasure
from adibas.data.protocol_measures import ProtocolMeasures
from adibas.data.views import VIEWS

__all__ = ("VIEWS", "PostureAnalysis", "Provenance")


@dataclass(frozen=True, slots=True)
class Provenance:
    """What a report was computed from, so that it can be computed again.

    Attributes
    ----------
    recording_sha256 : str
        Of the recording's bytes.
    calibration : str
        Identity of the calibration: ``sha256:`` and the hash of its canonical JSON.
    version : str
        Of this program.
    created_utc : str
        When the report was computed, ISO 8601.
    parameters : Mapping
        Every setting of every stage, by stage.
    """

    recording_sha256: str
    calibration: str
    version: str
    created_utc: str
    parameters: Mapping[str, object]


@dataclass(frozen=True, slots=True, eq=False)
class PostureAnalysis:
    """Markers of one burst and every distance and angle between them.

    Attributes
    ----------
    patient : str
        A pseudonym, never a name.
    view : str
        One of `VIEWS`, or empty where it was not told.
    n_frames : int
        Frames fused into the burst.
    first_frame : int
        Number of its first frame in the recording.
    picture_rgb : (H, W, 3) uint8 array
        A colour frame of the burst, without anything drawn.
    calibration : RgbdCalibration
        That the positions rest on.
    notices : tuple of str
        What the reader must know about the input, in sentences.
    surface_per_m : (H', W') float32 array or None
        Mean of 1/z over the burst, 1/metres, in the depth camera; NaN where nothing was measured.
        None where no depth was kept.
    measures : ProtocolMeasures or None
        What its protocol asks for; None where none was followed.
    """

    patient: str
    view: str
    n_frames: int
    first_frame: int
    markers: tuple[Marker, ...]
    rejected: tuple[RejectedBlob, ...]
    distances: tuple[DistanceMeasure, ...]
    angles: tuple[AngleMeasure, ...]
    picture_rgb: UInt8Array
    calibration: RgbdCalibration
    provenance: Provenance
    notices: tuple[str, ...] = field(default=())
    surface_per_m: Float32Array | None = None
    measures: ProtocolMeasures | None = None

    def __post_init__(self) -> None:
        if self.view not in ("", *VIEWS):
            raise ValueError(f"view must be one of {VIEWS}, got {self.view!r}")
        check_shape("picture_rgb", self.picture_rgb, (None, None, 3))
        if self.picture_rgb.dtype != np.uint8:
            raise ValueError(f"picture_rgb must be uint8, got {self.picture_rgb.dtype}")
        read_only(self.picture_rgb)
        if self.surface_per_m is not None:
            check_shape("surface_per_m", self.surface_per_m, (None, None))
            read_only(self.surface_per_m)
