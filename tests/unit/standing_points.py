"""A hand-made patient: places in metres (left, up, ahead), straight but where a test bends it."""

import numpy as np

from adibas.data.markers import Marker
from adibas.data.protocol_measures import VerticalOrigin
from adibas.measures.sight_plane import Vertical

MIDDLE = {
    "c7": (0.0, 1.50, -0.08),
    "t3": (0.0, 1.42, -0.10),
    "thoracic_apex": (0.0, 1.30, -0.12),
    "t12": (0.0, 1.10, -0.08),
}
ON_THE_LEFT = {
    "tragus": (0.07, 1.60, 0.0),
    "canthus": (0.04, 1.62, 0.08),
    "acromion": (0.18, 1.42, 0.0),
    "asis": (0.12, 0.98, 0.08),
    "psis": (0.05, 0.98, -0.10),
    "greater_trochanter": (0.16, 0.90, 0.0),
    "knee_joint_line": (0.16, 0.48, 0.0),
    "patella": (0.12, 0.50, 0.06),
    "tibial_tuberosity": (0.12, 0.42, 0.06),
    "lateral_malleolus": (0.16, 0.08, 0.0),
    "medial_malleolus": (0.08, 0.09, 0.0),
    "metatarsals": (0.12, 0.04, 0.15),
    "inferior_scapula": (0.09, 1.28, -0.12),
    "midleg": (0.12, 0.30, -0.05),
    "achilles": (0.12, 0.10, -0.05),
    "calcaneus": (0.12, 0.03, -0.05),
}
# Rows: the camera's x, y, z from (left, up, ahead).
CAMERA_FROM_BODY = {
    "anterior": np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]]),
    "posterior": np.array([[-1.0, 0, 0], [0, -1, 0], [0, 0, 1]]),
    "right_lateral": np.array([[0.0, 0, 1], [0, -1, 0], [1, 0, 0]]),
    "left_lateral": np.array([[0.0, 0, -1], [0, -1, 0], [-1, 0, 0]]),
}
LEVEL = Vertical(np.array([0.0, -1.0, 0.0]), 0.0, VerticalOrigin.GRAVITY, is_sd_known=True)


def standing():
    """Return a copy of all places."""
    places = {name: np.array(place) for name, place in MIDDLE.items()}
    for name, place in ON_THE_LEFT.items():
        places[f"left_{name}"] = np.array(place)
        places[f"right_{name}"] = np.array(place) * (-1, 1, 1)
    return places


def mirrored(places):
    """Return the mirror image of a patient: what was left is right."""
    other = {"left": "right", "right": "left"}
    return {
        "_".join(other.get(part, part) for part in name.split("_")): place * (-1, 1, 1)
        for name, place in places.items()
    }


def seen_from(view, places, *, sigma_m=0.001, rotation=None):
    """Return the markers in the axes of a camera 2 m away, one metre above the floor."""
    turn = CAMERA_FROM_BODY[view] if rotation is None else rotation @ CAMERA_FROM_BODY[view]
    offset = np.array([0.0, 0.0, 2.0]) - turn @ np.array([0.0, 1.0, 0.0])
    return [
        Marker(name, 0.0, 0.0, 5.0, np.eye(2), turn @ place + offset, sigma_m**2 * np.eye(3))
        for name, place in places.items()
    ]
