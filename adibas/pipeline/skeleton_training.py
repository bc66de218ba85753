"""From labelled shapes, of a file or of simulated people, to a skeleton model."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from adibas import __version__
from adibas.arrays import BoolArray, FloatArray
from adibas.clock import Clock, utc_now
from adibas.data.joints import JOINT_NAMES
from adibas.errors import FileError
from adibas.pipeline.skeleton_simulator import (
    KIND_SHARES,
    TRAINING_SHARES,
    LabelledShapes,
    simulate_shapes,
)
from adibas.progress import Progress
from adibas.recordings.checksum import recording_sha256
from adibas.shapes.point_distribution import LEAST_SHAPES, learn_distribution
from adibas.shapes.shape_fitting import fit_shape
from adibas.skeleton.model import PointModel, SkeletonModel
from adibas.skeleton.parts import PartsModel, has_parts
from adibas.skeleton.parts_training import PartsParams, learn_parts
from adibas.skeleton.points_csv import PointSet, read_points
from adibas.skeleton.stance_training import StanceParams, learn_stance
from adibas.skeleton.starts import HEADINGS_RAD
from adibas.skeleton.training import TrainingParams, learn_points, turned_about_y

PLANE, SPACE = 2, 3
LEAST_NAMES = 3
TEMPERATURE = 1.0
"""On simulated people whom the training had not seen 1 and 2 were tried; 1 is right as often."""
VIEW_SD_RAD = 0.2
"""How far patients stand from the view that was declared."""
N_PLANE_PROTOTYPES = 10
KIND_WEIGHTS: Mapping[str, float] = {
    "standing": 0.3,
    "moving": 0.2,
    "seated": 0.15,
    "gesture": 0.1,
    "table": 0.05,
    "active": 0.2,
}
"""How often a clinic meets them, ours."""
PARTS_SEED_OFF, STANCE_SEED_OFF = 10, 20
FILLING_SIGMA_M = 0.02


def train_from_file(path: Path, clock: Clock = utc_now) -> SkeletonModel:
    """Learn a model from labelled point sets of a CSV file; see `read_points`.

    Raises
    ------
    FileError
        The file is no such file, or its shapes do not suffice.
    """
    sets = read_points(path)
    names = tuple(sorted({label for one in sets for label in one.labels if label}))
    if set(names) == set(JOINT_NAMES):
        names = JOINT_NAMES
    if len(names) < LEAST_NAMES:
        raise FileError(
            "{file} names {n} different points, and a model needs three. Fill in the column label.",
            file=path.name,
            n=len(names),
        )
    source = {"source": path.name, "sha256": recording_sha256(path)}
    return learn_sets(path.name, names, sets, source, clock)


def learn_sets(
    called: str,
    names: tuple[str, ...],
    sets: Sequence[PointSet],
    source: Mapping[str, object],
    clock: Clock,
) -> SkeletonModel:
    """Learn a model from labelled point sets.

    Parameters
    ----------
    called : str
        What the sets are called in messages.
    names : tuple of str
        Of the points; labels beside them are not looked at.
    source : Mapping
        Where the sets are from: the beginning of the provenance.

    Raises
    ------
    FileError
        The shapes do not suffice.
    """
    in_space = [one for one in sets if one.positions_m.shape[1] == SPACE]
    space = _learn(called, names, in_space) if in_space else None
    parts = _learn_parts(names, in_space)
    planes: dict[str, PointModel] = {}
    for view in ("", *HEADINGS_RAD):
        of_view = [o for o in sets if o.positions_m.shape[1] == PLANE and o.view == view]
        if of_view:
            planes[view] = _learn(f"{called} [{view}]" if view else called, names, of_view)
    provenance = {
        **source,
        "n_shapes": len(sets),
        "version": __version__,
        "created_utc": clock().isoformat(timespec="seconds"),
        "training": asdict(TrainingParams()),
    }
    return SkeletonModel(space, planes, TEMPERATURE, provenance, parts)


@dataclass(frozen=True, slots=True)
class Drawn:
    """Which simulated people are learned from.

    Attributes
    ----------
    n_bodies, n_poses : int
        People, and poses of each.
    seed : int
        Of the draw.
    shares : Mapping
        Of the kinds of poses; they sum to 1.
    """

    n_bodies: int
    n_poses: int
    seed: int
    shares: Mapping[str, float]


PROTOTYPE_PEOPLE = Drawn(240, 60, 1, KIND_SHARES)
"""Of the shipped model's prototypes."""


def parts_people(prototypes: Drawn) -> Drawn:
    """Return whom core and limbs are learned from beside the prototypes' people: others.

    13 for each 24, in 7 poses for each 6, broader: the 130 and 70 of the shipped model.
    """
    return Drawn(
        -(-13 * prototypes.n_bodies // 24),
        -(-7 * prototypes.n_poses // 6),
        prototypes.seed + PARTS_SEED_OFF,
        TRAINING_SHARES,
    )


def standing_people(prototypes: Drawn) -> Drawn:
    """Return from whom is learned how all joints of people who stand lie together: others again.

    Four times as many in a third of the poses, the 960 and 20 of the shipped model: people differ
    more than one person's ways to stand.
    """
    return Drawn(
        4 * prototypes.n_bodies,
        -(-prototypes.n_poses // 3),
        prototypes.seed + STANCE_SEED_OFF,
        {"standing": 1.0},
    )


def train_from_simulator(
    people: Drawn, progress: Progress, clock: Clock = utc_now
) -> SkeletonModel:
    """Learn the 15 joints from simulated people, in space and in the plane of each view.

    Parameters
    ----------
    people : Drawn
        Of the prototypes; core and limbs are learned from `parts_people`, how people stand from
        `standing_people`.

    Raises
    ------
    FileError
        They are too few.
    """
    others = parts_people(people)
    n_shapes, least = others.n_bodies * others.n_poses, PartsParams().rows_per_component
    if n_shapes < least:
        raise FileError(
            "{bodies} bodies in {poses} poses are too few to learn from: they give {n} shapes for "
            "core and limbs, and a model needs {least}. Ask for more bodies or poses.",
            bodies=people.n_bodies,
            poses=people.n_poses,
            n=n_shapes,
            least=least,
        )
    of_stance = standing_people(people)
    learned, of_parts, standing = _all_simulated((people, others, of_stance), progress)
    params, parts_params = TrainingParams(), PartsParams(weights=KIND_WEIGHTS)
    stance_params = StanceParams()
    parts = learn_parts(JOINT_NAMES, of_parts.shapes_m, of_parts.kinds, parts_params)
    stance = learn_stance(JOINT_NAMES, standing.shapes_m, stance_params)
    in_plane = TrainingParams(n_prototypes=N_PLANE_PROTOTYPES)
    return SkeletonModel(
        learn_points(JOINT_NAMES, learned.shapes_m, learned.kinds, params),
        _learn_planes(learned, people.seed, in_plane),
        TEMPERATURE,
        {
            "source": "simulated people: adibas skeleton train --simulator",
            "prototypes_from": asdict(people),
            "parts_from": asdict(others),
            "stance_from": asdict(of_stance),
            "version": __version__,
            "created_utc": clock().isoformat(timespec="seconds"),
            "training": asdict(params),
            "training_in_plane": asdict(in_plane),
            "training_of_parts": asdict(parts_params),
            "training_of_stance": asdict(stance_params),
        },
        replace(parts, stance=stance),
    )


def _all_simulated(drawn: Sequence[Drawn], progress: Progress) -> list[LabelledShapes]:
    """Simulate one lot of people after the other; progress is that of all."""
    n_people = sum(people.n_bodies for people in drawn)
    found = []
    n_before = 0
    for people in drawn:

        def told(done: int, _all: int, n_before: int = n_before) -> None:
            progress(n_before + done, n_people)

        found.append(
            simulate_shapes(people.n_bodies, people.n_poses, people.seed, told, people.shares)
        )
        n_before += people.n_bodies
    return found


def _learn_planes(
    learned: LabelledShapes, seed: int, params: TrainingParams
) -> dict[str, PointModel]:
    rng = np.random.default_rng([seed, 1])
    planes = {}
    for view, heading_rad in HEADINGS_RAD.items():
        angles = heading_rad + rng.normal(scale=VIEW_SD_RAD, size=len(learned.shapes_m))
        seen = turned_about_y(learned.shapes_m, angles)[..., :PLANE]
        planes[view] = learn_points(JOINT_NAMES, np.ascontiguousarray(seen), learned.kinds, params)
    return planes


def _learn_parts(names: tuple[str, ...], sets: Sequence[PointSet]) -> PartsModel | None:
    """Return core and limbs where the names are the joints and there are shapes enough."""
    shapes_m = _shapes(names, sets) if sets else np.zeros((0, len(names), SPACE))
    whole_m = shapes_m[~np.isnan(shapes_m).any(axis=(1, 2))]
    params = PartsParams()
    if not has_parts(names) or len(whole_m) < params.rows_per_component:
        return None
    return learn_parts(names, whole_m, [""] * len(whole_m), params)


def _shapes(names: tuple[str, ...], sets: Sequence[PointSet]) -> FloatArray:
    """Return the (S, N, D) points of sets in the order of the names, NaN where there is none."""
    shapes_m = np.full((len(sets), len(names), sets[0].positions_m.shape[1]), np.nan)
    for shape_m, one in zip(shapes_m, sets, strict=True):
        for label, position_m in zip(one.labels, one.positions_m, strict=True):
            if label:
                shape_m[names.index(label)] = position_m
    return shapes_m


def _learn(called: str, names: tuple[str, ...], sets: Sequence[PointSet]) -> PointModel:
    shapes_m = _shapes(names, sets)
    is_whole: BoolArray = np.asarray(~np.isnan(shapes_m).any(axis=(1, 2)))
    if np.count_nonzero(is_whole) < LEAST_SHAPES:
        raise FileError(
            "{file} has {n} shapes with all {n_names} names, and a model needs at least three. Add "
            "shapes, or leave out names that few of them have.",
            file=called,
            n=int(np.count_nonzero(is_whole)),
            n_names=len(names),
        )
    try:
        return learn_points(names, _filled(names, shapes_m, is_whole))
    except ValueError as error:
        raise FileError(
            "The shapes in {file} make no model: they are all the same, or their points lie on one "
            "line.",
            file=called,
        ) from error


def _filled(names: tuple[str, ...], shapes_m: FloatArray, is_whole: BoolArray) -> FloatArray:
    """Return the shapes, missing points put where the whole ones let expect them."""
    if is_whole.all():
        return shapes_m
    model = learn_distribution(names, shapes_m[is_whole])
    filled = list(shapes_m[is_whole])
    for shape_m in shapes_m[~is_whole]:
        fit = fit_shape(model, shape_m, FILLING_SIGMA_M)
        if fit is not None:
            filled.append(np.where(np.isnan(shape_m), fit.points, shape_m))
    return np.stack(filled)
