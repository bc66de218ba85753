"""Learns from simulated people where markers of joints are on the body that is found without them.

Run as a module it makes ``resources/models/body-marks.json`` again, for the shipped model of limbs.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray, IntArray
from adibas.data.joints import JOINT_NAMES
from adibas.pipeline.body_marks_file import write_marks
from adibas.pipeline.marked_people import MarkedPicture, marked_pictures
from adibas.pipeline.seen_body import SeenBody, body_in
from adibas.pipeline.shipped_limbs import shipped_model
from adibas.pipeline.skeleton_names import upright_turn
from adibas.skeleton.body_marks import (
    ACROSS,
    N_PARTS,
    OTHER_JOINTS,
    OTHER_PARTS,
    VIEWS,
    BodyMarks,
    ViewMarks,
)

SEED, N_PICTURES = 6010, 2400
FARTHEST = 14.2
"""Squared distance in standard deviations; three in a thousand of three dimensions are beyond."""
N_ROUNDS = 8
LEAST_SD_M = 0.01
PRIOR = 0.5
"""Markers that are taken to show the parts of the whole body beside those that were seen."""


@dataclass(frozen=True, slots=True, eq=False)
class Example:
    """Markers of one picture, as seen from their view; of a left side the mirror image.

    Attributes
    ----------
    view : str
        One of `VIEWS`.
    joints : (M,) int array
        Of `JOINT_NAMES`.
    offsets_m : (M, 3) array
        From the joint that was found, upright; NaN where it was not.
    shares : (M, 16) array
        About each marker; NaN where nothing of the body is.
    whole : (16,) array
        In the whole body.
    """

    view: str
    joints: IntArray
    offsets_m: FloatArray
    shares: FloatArray
    whole: FloatArray

    def mirrored(self) -> "Example":
        """Return the mirror image."""
        return Example(
            self.view,
            OTHER_JOINTS[self.joints],
            self.offsets_m * ACROSS,
            self.shares[:, OTHER_PARTS],
            self.whole[OTHER_PARTS],
        )


def examples_of(pictures: Iterable[MarkedPicture]) -> Iterator[Example]:
    """Give what pictures teach in which somebody is found; fronts and backs mirrored as well."""
    for picture in pictures:
        body = body_in(picture.depth_m, picture.mask, picture.view, picture.camera)
        if body is None or not picture.names:
            continue
        example = _example(picture, body)
        if picture.view == "left_lateral":
            yield example.mirrored()
            continue
        yield example
        if example.view != "lateral":
            yield example.mirrored()


def _example(picture: MarkedPicture, body: SeenBody) -> Example:
    joints = np.array([JOINT_NAMES.index(name) for name in picture.names])
    off_m = picture.points_m - body.joints_m[joints]
    mean = body.parts.probabilities.mean(axis=0, dtype=float)
    return Example(
        picture.view if picture.view in VIEWS else "lateral",
        joints,
        off_m @ upright_turn(picture.up).T,
        body.shares_around(picture.points_m),
        np.append(mean, 1.0 - mean.sum()),
    )


def learn_marks(examples: Iterable[Example], provenance: dict[str, object]) -> BodyMarks:
    """Return what examples of all views teach."""
    every = tuple(examples)
    views = {view: _learn_view([one for one in every if one.view == view]) for view in VIEWS}
    return BodyMarks(views, provenance)


def _learn_view(examples: list[Example]) -> ViewMarks:
    joints = np.concatenate([one.joints for one in examples])
    offsets_m = np.concatenate([one.offsets_m for one in examples])
    shares = np.concatenate([one.shares for one in examples])
    whole = np.mean([one.whole for one in examples], axis=0)
    n = len(JOINT_NAMES)
    means_m, covariances_m2 = np.empty((n, 3)), np.empty((n, 3, 3))
    part_odds = np.empty((n, N_PARTS))
    for joint in range(n):
        own = joints == joint
        means_m[joint], covariances_m2[joint] = _most_of(offsets_m[own])
        part_odds[joint] = _odds_of_parts(shares[own], whole)
    return ViewMarks(means_m, covariances_m2, part_odds)


def _most_of(offsets_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return mean and covariance of offsets without those far off: joints found elsewhere."""
    offsets_m = offsets_m[~np.isnan(offsets_m[:, 0])]
    kept = np.ones(len(offsets_m), bool)
    for _ in range(N_ROUNDS):
        mean_m = offsets_m[kept].mean(axis=0)
        covariance_m2 = np.cov(offsets_m[kept].T) + LEAST_SD_M**2 * np.eye(3)
        off_m = offsets_m - mean_m
        squared = np.einsum("mi,ij,mj->m", off_m, np.linalg.inv(covariance_m2), off_m)
        kept = squared < FARTHEST
    return mean_m, covariance_m2


def _odds_of_parts(shares: FloatArray, whole: FloatArray) -> FloatArray:
    shares = shares[~np.isnan(shares[:, 0])]
    about = (shares.sum(axis=0) + PRIOR * whole) / (len(shares) + PRIOR)
    return np.asarray(np.log(about / whole))


def learn(seed: int = SEED, n_pictures: int = N_PICTURES) -> BodyMarks:
    """Return what the simulator teaches; the same every time."""
    examples = tuple(examples_of(marked_pictures(seed, n_pictures)))
    provenance: dict[str, object] = {
        "seed": seed,
        "n_pictures": n_pictures,
        "n_examples": len(examples),
        "n_markers": int(sum(len(one.joints) for one in examples)),
        "limbs_created_utc": shipped_model().created_utc,
    }
    return learn_marks(examples, provenance)


if __name__ == "__main__":
    write_marks(learn())
