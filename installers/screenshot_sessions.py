"""Sessions to compare for the screenshots: the demo patient as she stood some weeks ago and today.

The simulator knows which landmark every marker is; earlier sessions have the demo's pictures, and
markers that were placed anew and a little elsewhere.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from adibas.arrays import FloatArray, UInt8Array
from adibas.data.frames import depth_in_metres
from adibas.data.markers import Marker
from adibas.data.patients import PURPOSE_OF_CAPTURE, Consent, Identity
from adibas.data.sessions import Capture, SessionSetup
from adibas.data.surface import BurstDisparity
from adibas.markers.disparity import fuse_depth
from adibas.sessions import NewCapture, SessionStore, open_store
from adibas.sessions.key_wrapping import Argon2Params
from adibas.simulation.patient import MarkerSettings
from adibas.simulation.scenes import VIEW_MARKERS, open_scene
from adibas.simulation.truth import MarkerTruth

PROTOCOL = "sapo-1"
IN_PROTOCOL = {"shoulder": "acromion", "elbow": "lateral_epicondyle"}
"""Landmarks beside the joints that the demo patient has stickers at."""
FARTHEST_PX = 60.0
"""Between a marker and the landmark that it is of: the patient sways."""
PLACED_ANEW_M = 0.002
DAYS_AGO = (84, 56, 28, 0)
LOWER_M = (0.018, 0.012, 0.008, 0.0)
"""The left side in each session."""
N_OTHERS = 10
BEFORE, N_FRAMES = "leaning", 10
"""How the patient stood in earlier sessions, and for how many frames."""


@dataclass(frozen=True, slots=True, eq=False)
class _Sample:
    """A capture of the demo, its markers by name, its picture, and its depth now and before."""

    capture: Capture
    markers: tuple[Marker, ...]
    picture_rgb: UInt8Array
    surface: BurstDisparity | None
    surface_before: BurstDisparity


def add_sessions_to_compare(
    folder: Path, session_id: str, passphrase: str, params: Argon2Params
) -> None:
    """Add sessions of the demo patient, and repeats of others, to the store in a folder."""
    rng = np.random.default_rng(5)
    with _opened(folder, passphrase, params, 0) as store:
        patient = store.sessions.get(session_id).patient
        samples = [
            _Sample(
                one,
                tuple(_named(one)),
                store.captures.picture(one.capture_id),
                store.captures.surface(one.capture_id),
                _leaning(one),
            )
            for one in store.captures.of_session(session_id)
        ]
    for days_ago, lower_m in zip(DAYS_AGO, LOWER_M, strict=True):
        with _opened(folder, passphrase, params, days_ago) as store:
            _add(store, patient, samples, lower_m, rng)
    with _opened(folder, passphrase, params, max(DAYS_AGO) + 1) as store:
        for number in range(N_OTHERS):
            identity = Identity(f"Demo {number + 1:02d}", None, f"D-{number + 1:02d}")
            other = store.patients.add(identity).pseudonym
            own = Consent((PURPOSE_OF_CAPTURE,), identity.name, False, store.audit.now_utc())
            store.patients.give_consent(other, own)
            for _visit in range(2):
                _add(store, other, samples[:1], 0.002 * number, rng)


def _opened(folder: Path, passphrase: str, params: Argon2Params, days_ago: int) -> SessionStore:
    began = datetime.now(UTC) - timedelta(days=days_ago)

    def clock() -> datetime:
        return began

    return open_store(folder, passphrase, operator="M. Puig", key_params=params, clock=clock)


def _add(
    store: SessionStore,
    patient: str,
    samples: Sequence[_Sample],
    lower_m: float,
    rng: np.random.Generator,
) -> None:
    session = store.sessions.start(patient, SessionSetup(protocol=PROTOCOL))
    repeated = replace(session.setup, is_repeat=True)
    store.sessions.change(session.session_id, setup=repeated, seen=session)
    for sample in samples:
        capture = sample.capture
        new = NewCapture(
            view=capture.view,
            recording_id="",
            first_frame=0,
            n_frames=capture.n_frames,
            calibration=capture.calibration,
            detected=tuple(_placed(one, lower_m, rng, capture) for one in sample.markers),
            rejected=(),
            provenance=capture.provenance,
        )
        surface = sample.surface_before if lower_m else sample.surface
        store.captures.add(session.session_id, new, sample.picture_rgb, surface)


def _leaning(capture: Capture) -> BurstDisparity:
    """Return the depth of the demo patient standing as she did before."""
    scene = open_scene(capture.view, posture=BEFORE, has_color=False)
    frames = (scene.frame(index).sensor_frame.depth_raw for index in range(N_FRAMES))
    return fuse_depth(
        (depth_in_metres(raw, scene.info.depth_unit_m) for raw in frames if raw is not None),
        capture.calibration.depth_bias,
        capture.calibration.depth,
    )


def _named(capture: Capture) -> Iterator[Marker]:
    """Yield the markers where the landmarks are that they stand for, under their names."""
    truth, landmarks = _stickers(capture.view, {}), _stickers(capture.view, IN_PROTOCOL)
    places = {name: (one.u, one.v) for name, one in truth.items() if one.is_in_view}
    for marker in capture.markers():
        here = (marker.u, marker.v)
        name = min(places, key=lambda one, here=here: math.dist(places[one], here))
        if math.dist(places.pop(name), here) < FARTHEST_PX:
            told = _in_protocol(name, IN_PROTOCOL)
            yield _moved(marker, truth[name], landmarks[told], told)


def _stickers(view: str, names: Mapping[str, str]) -> dict[str, MarkerTruth]:
    """Return the stickers of a view that the simulator knows, some in other places."""
    wanted = tuple(_in_protocol(name, names) for name in VIEW_MARKERS[view])
    truth = open_scene(view, markers=MarkerSettings(wanted)).frame(0).truth
    return {one.name: one for one in truth.markers}


def _moved(marker: Marker, old: MarkerTruth, new: MarkerTruth, label: str) -> Marker:
    """Return the marker as far from the new place as it was from the old one."""
    position_m = marker.position_m
    return replace(
        marker,
        label=label,
        u=float(marker.u + new.u - old.u),
        v=float(marker.v + new.v - old.v),
        position_m=None if position_m is None else position_m + new.position_m - old.position_m,
    )


def _in_protocol(name: str, names: Mapping[str, str]) -> str:
    side, _underscore, place = name.partition("_")
    return f"{side}_{names[place]}" if place in names else name


def _placed(marker: Marker, lower_m: float, rng: np.random.Generator, capture: Capture) -> Marker:
    """Return the marker as if it had been stuck on anew."""
    camera = capture.calibration.color
    if marker.position_m is None or camera is None:
        return marker
    step_m: FloatArray = rng.normal(0.0, PLACED_ANEW_M, 3)
    if marker.label.startswith("left_"):
        step_m = step_m + np.array([0.0, lower_m, 0.0])
    px_per_m = camera.intrinsics.fx / marker.position_m[2]
    return replace(
        marker,
        u=float(marker.u + px_per_m * step_m[0]),
        v=float(marker.v + px_per_m * step_m[1]),
        position_m=marker.position_m + step_m,
    )
