"""What is drawn over a live frame. Knows nothing of Qt."""

import math
from collections.abc import Callable, Iterator, Mapping

from adibas.pipeline.live import LiveFrame
from adibas.texts import decimal_mark
from adibas.texts import translate as _
from ui.widgets.bones import bones
from ui.widgets.overlays import Dot, Line, Overlay, Region

JOINT_RADIUS_PX = 2.0


def overlays_of(frame: LiveFrame, shows: Callable[[str], bool]) -> tuple[Overlay, ...]:
    """Return body, markers with their bones and plumb line, as far as `shows` wants them."""
    overlays: list[Overlay] = []
    if shows("body") and frame.outline is not None:
        overlays.append(Region(frame.outline))
    if shows("plumb") and frame.plumb is not None:
        overlays += _plumb(frame)
    if shows("markers"):
        overlays += bones(frame.joints)
    if shows("markers") and frame.detections is not None:
        overlays += [Dot(blob.u, blob.v, blob.radius_px) for blob in frame.detections.blobs]
        overlays += [
            Dot(blob.u, blob.v, 3.0, role="rejected", tooltip=_(blob.reason))
            for blob in frame.detections.rejected
        ]
    return tuple(overlays)


def joints_of(people: Mapping[int, Mapping[str, tuple[float, float]]]) -> Iterator[Overlay]:
    """Return what was found without markers: joints, bones, and who is who among several.

    Parameters
    ----------
    people : dict
        Pixels of joints by name, by the person's number.
    """
    for person, places in people.items():
        yield from bones(places, "markerless")
        named = next(iter(places), "") if len(people) > 1 else ""
        for joint, (u, v) in places.items():
            label = str(person) if joint == named else ""
            yield Dot(u, v, JOINT_RADIUS_PX, label, role="markerless")


def _plumb(frame: LiveFrame) -> list[Overlay]:
    plumb = frame.plumb
    if plumb is None:
        return []
    lines: list[Overlay] = []
    if plumb.vertical is not None:
        (u1, v1), (u2, v2) = plumb.vertical
        lean = f"{math.degrees(plumb.roll_rad):+z.1f}°".replace(".", decimal_mark())
        lines.append(Line(u1, v1, u2, v2, "plumb", lean))
    if plumb.horizon is not None:
        (u1, v1), (u2, v2) = plumb.horizon
        lines.append(Line(u1, v1, u2, v2, "plumb"))
    return lines
