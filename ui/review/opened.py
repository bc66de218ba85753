"""What a capture is edited with: its picture and surface, and the landmarks of its protocol."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from adibas.arrays import UInt8Array
from adibas.data.markers import Marker

if TYPE_CHECKING:
    from adibas.data.protocols import Protocol as LandmarkProtocol
    from adibas.pipeline.posture import MarkerTarget
    from adibas.pipeline.review import CaptureSurface


@dataclass(frozen=True, slots=True, eq=False)
class Opened:
    """What editing a capture needs.

    Attributes
    ----------
    picture_rgb : (H, W, 3) uint8 array
        Of the capture.
    surface : CaptureSurface
        Gives positions.
    target : MarkerTarget or None
        What markers look like, for snapping.
    protocol : Protocol or None
        Of the session: its landmarks are what markers are named after, its measures what is shown.
    rotation_deg : int
        How far the picture is turned clockwise to be upright.
    """

    picture_rgb: UInt8Array
    surface: "CaptureSurface"
    target: "MarkerTarget | None"
    protocol: "LandmarkProtocol | None" = None
    rotation_deg: int = 0

    def placed(
        self, label: str, u: float, v: float, *, is_free: bool, before: Marker | None = None
    ) -> Marker:
        """Return a marker at the blob nearest to (u, v), or right there, as large as it was."""
        if not is_free:
            found = self.surface.snapped(self.picture_rgb, u, v, target=self.target)
            if found.is_blob:
                return self.surface.measured(
                    label, found.u, found.v, found.covariance_px2, found.radius_px
                )
        if before is None:
            return self.surface.measured(label, u, v)
        return self.surface.measured(label, u, v, radius_px=before.radius_px)


class PassedLandmarks:
    """Landmarks that were passed over while names are given one after the other."""

    def __init__(self) -> None:
        self._passed: set[str] = set()

    def pass_over(self, landmark: str | None) -> None:
        """Name this one last."""
        if landmark is not None:
            self._passed.add(landmark)

    def order(self, unmarked: Iterable[str]) -> tuple[str, ...]:
        """Return them as they are due; when all were passed over, it begins anew."""
        missing = tuple(unmarked)
        if self._passed.issuperset(missing):
            self._passed.clear()
        return tuple(sorted(missing, key=self._passed.__contains__))
