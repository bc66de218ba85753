"""Simulated people with markers who move before a depth camera: films of `marked_people`.

Where a joint is marked stays the same in a film: a place that the camera sees in most of its
frames. In each frame what is hidden is missing.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from adibas.arrays import FloatArray
from adibas.pipeline.marked_people import (
    MarkedPicture,
    frame_settings,
    marked,
    most_seen,
    places_of,
)
from adibas.simulation.figures import Figure
from adibas.simulation.gestures import gesture_names, perform
from adibas.simulation.limb_frames import Film, LimbFrames, dressed_person
from adibas.simulation.poses import Pose
from adibas.simulation.random_poses import random_figure
from adibas.skeleton.starts import HEADINGS_RAD

ANYHOW, GESTURE, SEATED, TURNING = "moving anyhow", "a gesture", "seated", "turning round"
FILM_KINDS = (ANYHOW, GESTURE, SEATED, TURNING)
RATE_HZ, N_FRAMES = 15.0, 30
FILMS_A_PERSON = 8


@dataclass(frozen=True, slots=True, eq=False)
class MarkedFilm:
    """One movement.

    Attributes
    ----------
    kind : str
        One of `FILM_KINDS`.
    view : str
        Which side the camera sees at first.
    times_s : (T,) array
    pictures : tuple of MarkedPicture
    """

    kind: str
    view: str
    times_s: FloatArray
    pictures: tuple[MarkedPicture, ...]


def marked_films(seed: int, n_films: int, first: int = 0) -> Iterator[MarkedFilm]:
    """Give films `first` to `n_films`, of kinds and views in turn.

    Film i depends on the seed and i alone.
    """
    views = list(HEADINGS_RAD)
    for number in range(first, n_films):
        kind = FILM_KINDS[number % len(FILM_KINDS)]
        view = views[number // len(FILM_KINDS) % len(views)]
        yield _film(seed, number, kind, view)


def _film(seed: int, number: int, kind: str, view: str) -> MarkedFilm:
    rng = np.random.default_rng([seed, 0x55, number])
    person = number // FILMS_A_PERSON
    dressed = dressed_person(seed, person)
    sensor = LimbFrames(seed, frame_settings(HEADINGS_RAD[view]))
    posture = "seated" if kind == SEATED else "moving"
    poses = list(_poses(rng, kind))
    film = Film(number, poses[0])
    frames = [
        sensor.seen(dressed, pose, (person, posture), index, film)
        for index, pose in enumerate(poses, number * N_FRAMES)
    ]
    places = [places_of(frame, dressed, sensor.camera) for frame in frames]
    chosen = [most_seen(rng, moments) for moments in zip(*places, strict=True)]
    pictures = tuple(
        marked(rng, frame, sensor.camera, (kind, view), zip(own, chosen, strict=True))
        for frame, own in zip(frames, places, strict=True)
    )
    return MarkedFilm(kind, view, np.arange(len(frames)) / RATE_HZ, pictures)


def _poses(rng: np.random.Generator, kind: str) -> Iterator[Pose]:
    """Give the poses of a film's frames."""
    if kind == GESTURE:
        names = [name for name in gesture_names() if name != "idle"]
        gesture = perform(str(rng.choice(names)), int(rng.integers(2**31)))
        for index in range(N_FRAMES):
            yield gesture.pose(index / RATE_HZ)
        return
    if kind == TURNING:
        stands, way = random_figure(rng, "standing").pose(), float(rng.choice([-1.0, 1.0]))
        for index in range(N_FRAMES):
            yield replace(stands, heading_rad=way * math.pi * index / N_FRAMES)
        return
    if kind == SEATED:
        first, other = (random_figure(rng, "seated") for _ in range(2))
        other = replace(other, left_leg=first.left_leg, right_leg=first.right_leg)
    else:
        first, other = random_figure(rng, "standing"), random_figure(rng, "moving")
    ends = first.vector(), other.vector()
    for index in range(N_FRAMES):
        share = 0.5 - 0.5 * math.cos(2.0 * math.pi * index / N_FRAMES)
        yield Figure.from_vector((1.0 - share) * ends[0] + share * ends[1]).pose()
