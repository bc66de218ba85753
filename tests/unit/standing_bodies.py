"""Sessions with the depth of simulated people who stand before the sensor, in a real store."""

from functools import cache

import numpy as np

from adibas.data.posture import Provenance
from adibas.data.sessions import SessionSetup
from adibas.markers.disparity import fuse_depth
from adibas.sessions import NewCapture
from benchmarks.body_scenes import burst, draw_back_scene

PROVENANCE = Provenance("", "", "1", "2026-01-01T00:00:00+00:00", {})
SEED, N_FRAMES = 5, 4


def unheard(_done, _total):
    """Hear of progress, and do nothing."""


@cache
def scene():
    return draw_back_scene(SEED, 2.6)


@cache
def surface(view):
    """Return the mean depth of a view, as a capture keeps it."""
    calibration = scene().calibration
    frames = burst(scene(), scene().posed(view), N_FRAMES, SEED)
    return fuse_depth(frames, calibration.depth_bias, calibration.depth)


def picture():
    camera = scene().calibration.color
    return np.full((camera.height, camera.width, 3), 120, np.uint8)


def add_body_session(store, patient, views=("posterior",), *, without_depth=(), markers=()):
    """Add a session with a capture of each view; return it."""
    session = store.sessions.start(patient, SessionSetup())
    kept = [(view, surface(view)) for view in views] + [(view, None) for view in without_depth]
    for view, depth in kept:
        new = NewCapture(
            view=view,
            recording_id="",
            first_frame=0,
            n_frames=N_FRAMES,
            calibration=scene().calibration,
            detected=tuple(markers),
            rejected=(),
            provenance=PROVENANCE,
        )
        store.captures.add(session.session_id, new, picture(), depth)
    return store.sessions.get(session.session_id)
