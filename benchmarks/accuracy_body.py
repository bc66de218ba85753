"""The back and the whole body of simulated people with bent spines, sensor noise as documented.

The truth of a spine is the skin over the spinous processes; of a surface, the body's mesh.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from adibas.arrays import BoolArray, FloatArray
from adibas.data.body_measures import BodyMeasure
from adibas.data.calibration import RgbdCalibration
from adibas.errors import BodyError
from adibas.geometry.rigid import RigidTransform
from adibas.markers.disparity import fuse_depth
from adibas.pipeline.back import Back, BackParams, measure_back
from adibas.pipeline.body import girths_of
from adibas.pipeline.body_views import LEAST_SHARE, BodyView, person_in
from adibas.pipeline.capturing import frames_of_view
from adibas.pipeline.whole_body import WholeBody, join_body
from adibas.simulation.depth_noise import EXACT
from adibas.simulation.poses import DOWN, FORWARD, HEADINGS_RAD, LEFT, View
from adibas.simulation.rotations import about
from adibas.surface.back_measures import ROTATION_MAX, ROTATION_RMS
from adibas.surface.course_errors import greatest, rms
from adibas.surface.trunk import back_points
from benchmarks.body_courses import Deviations
from benchmarks.body_girths import Girths
from benchmarks.body_scenes import BackScene, burst, draw_back_scene, true_midline_m
from benchmarks.body_truth import distances_mm, plain_truth, smoothed_truth, true_rotation_rad
from benchmarks.body_turns import turn_rows
from benchmarks.table import Row

BACK_SEEDS = range(3000, 3280)
"""So many that more than 1,000 intervals of angles and fleches are counted."""
QUICK_BACKS = 8
BODY_SEEDS = range(4000, 4010)
QUICK_BODIES = 2
N_FRAMES = 30
"""Of a burst; what a view gets of them is what the program's window takes."""
VIEWS: tuple[View, ...] = ("posterior", "anterior", "right_lateral", "left_lateral")
SWAY_M, SWAY_RAD = 0.005, np.radians(1.0)
FAR_MM = 5.0
Rotation = tuple[tuple[float, bool], tuple[float, bool]]
"""Errors in degrees, and whether the interval holds: of the root mean square, of the greatest."""
LANDMARKS = ("c7", "left_acromion", "right_acromion", "left_greater_trochanter", "sternal_notch")


def rows(*, quick: bool) -> Iterable[Row]:
    """Measure; with `quick` a few bodies of each."""
    yield from _backs(BACK_SEEDS[:QUICK_BACKS] if quick else BACK_SEEDS)
    seeds = BODY_SEEDS[:QUICK_BODIES] if quick else BODY_SEEDS
    yield from _bodies(seeds, "statue", 0.0)
    yield from _bodies(seeds, "5 mm and 1 deg of sway between views", 1.0)
    yield from turn_rows(seeds)


@dataclass(frozen=True, slots=True)
class Spine:
    """One back: errors of angles (degrees) and fleches (mm), and whether intervals hold them."""

    errors: FloatArray
    plain_errors: FloatArray
    held: BoolArray
    aside_mm: float
    rotation: Rotation


def _backs(seeds: range) -> Iterator[Row]:
    spines: list[Spine] = []
    of_one_burst: list[FloatArray] = []
    deviations = Deviations()
    for seed in seeds:
        scene = draw_back_scene(seed)
        view = _seen(scene, "posterior", seed)
        spine = _spine(scene, view, seed)
        if spine is not None:
            spines.append(spine)
            deviations.add(scene, view, seed)
        short = _spine(scene, _seen(scene, "posterior", seed, n_frames=N_FRAMES), seed)
        if short is not None:
            of_one_burst.append(short.errors)
    asked = f"frames at 2 m, seeds {seeds[0]}-{seeds[-1]}"
    told = f"bent spines, {frames_of_view('posterior', N_FRAMES)} {asked}"
    for column, name in enumerate(("kyphosis", "lordosis")):
        short_error = rms(np.array(of_one_burst)[:, column])
        yield Row(f"bent spines, {N_FRAMES} {asked}: {name}, rms", short_error, "deg")
    errors, plain, held, aside_mm = (
        np.array([getattr(one, name) for one in spines])
        for name in ("errors", "plain_errors", "held", "aside_mm")
    )
    yield from _spine_rows(told, errors, plain)
    share = 100.0 * float(held.mean())
    yield Row(
        f"{told}: intervals that hold the truth ({held.size})", share, "%", 95.0, "goal 93-97"
    )
    yield from _rotation_rows(told, [one.rotation for one in spines])
    yield from deviations.rows(told)
    yield Row(f"{told}: line of the spine, aside, rms", rms(aside_mm), "mm")
    yield Row(f"{told}: not measured", float(len(seeds) - len(spines)), f"of {len(seeds)}")


def _spine(scene: BackScene, view: BodyView, seed: int) -> Spine | None:
    """Measure one back; None where it or its curves are not found."""
    try:
        back = measure_back(view)
    except BodyError:
        return None
    if back.shape is None:
        return None
    midline_m = back.patient_from_camera.apply(
        scene.depth_from_world.apply(true_midline_m(scene, scene.posed("posterior")))
    )
    factors = np.array([np.degrees(1.0), np.degrees(1.0), 1e3, 1e3])
    found = factors * np.array([one.value for one in back.measures[:4]])
    ends = np.array([one.interval for one in back.measures[:4]], float)
    half = factors * (ends[:, 1] - ends[:, 0]) / 2.0
    known = (back.stature_m, back.profile.top_m)
    errors = found - smoothed_truth(midline_m, *known).values()
    return Spine(
        errors,
        found - plain_truth(midline_m, *known).values(),
        np.abs(errors) <= half,
        _aside_mm(back, midline_m),
        _rotation(scene, back, midline_m, seed),
    )


def _spine_rows(told: str, errors: FloatArray, plain: FloatArray) -> Iterator[Row]:
    for column, name in enumerate(("kyphosis", "lordosis")):
        some = errors[:, column]
        yield Row(f"{told}: {name}, rms", rms(some), "deg", 2.0, "goal <=")
        yield Row("same, within 2 deg", 100.0 * float((np.abs(some) <= 2.0).mean()), "%")
        yield Row("same, mean", float(some.mean()), "deg")
        yield Row("same, against tangents on 60 mm of the skin, rms", rms(plain[:, column]), "deg")
    for column, name in enumerate(("fleche cervicale", "fleche lombaire"), 2):
        yield Row(f"{told}: {name}, rms", rms(errors[:, column]), "mm")


def _aside_mm(back: Back, midline_m: FloatArray) -> float:
    y_m = np.linspace(0.58, 0.84, 60) * back.stature_m
    true_m = np.interp(y_m, midline_m[::-1, 1], midline_m[::-1, 0])
    return 1e3 * rms(back.line.at(y_m) - true_m)


def _rotation_rows(told: str, found: Sequence[Rotation]) -> Iterator[Row]:
    for number, name in enumerate(("root mean square", "greatest")):
        off_deg, is_held = (
            np.array(column) for column in zip(*(one[number] for one in found), strict=True)
        )
        yield Row(f"{told}: surface rotation, {name}: error, rms", rms(off_deg), "deg")
        share = 100.0 * float(np.mean(is_held))
        held = f"{told}: intervals of this that hold the truth ({len(is_held)})"
        yield Row(held, share, "%", 95.0, "goal 93-97")


def _rotation(scene: BackScene, back: Back, midline_m: FloatArray, seed: int) -> Rotation:
    """Return the errors of rotation and of the greatest one, and whether the intervals hold."""
    calibration = scene.calibration
    frames = burst(scene, scene.posed("posterior"), 1, seed, EXACT)
    surface = fuse_depth(frames, calibration.depth_bias, calibration.depth)
    clean = person_in("posterior", surface, calibration)
    points_m = back.patient_from_camera.apply(clean.points_m())
    points_m = points_m[back_points(points_m, back.stature_m, BackParams().trunk)]
    course_rad = true_rotation_rad(points_m, midline_m, back)
    found = {one.definition: one for one in back.measures}
    return (
        _against(found[ROTATION_RMS], rms(course_rad)),
        _against(found[ROTATION_MAX], greatest(course_rad)),
    )


def _against(found: BodyMeasure, truth_rad: float) -> tuple[float, bool]:
    if found.value is None or found.interval is None:
        raise ValueError("the rotation of a measured back has an interval")
    low_rad, high_rad = found.interval
    return float(np.degrees(found.value - truth_rad)), low_rad <= truth_rad <= high_rad


def _bodies(seeds: range, told: str, sway: float) -> Iterator[Row]:
    squares, slanted, apart, landmarks, n_refused = [], [], [], [], 0
    girths = Girths()
    for seed in seeds:
        scene = draw_back_scene(seed, is_portrait=True)
        motions = _sways(seed, sway)
        views = [
            _seen(scene, view, 10 * seed + number, sway, motions[number])
            for number, view in enumerate(VIEWS)
        ]
        try:
            whole = join_body(views)
        except BodyError:
            n_refused += 1
            continue
        girths.add(scene, whole, girths_of(whole, views))
        off_mm = _off_mm(scene, whole)
        squares.append(off_mm)
        slanted.append(np.abs(off_mm) > FAR_MM)
        some_apart, some_marks = _poses(scene, whole, motions)
        apart += some_apart
        landmarks += some_marks
    name = f"four views, {told}, seeds {seeds[0]}-{seeds[-1]}"
    error = rms(np.concatenate(squares))
    yield Row(f"{name}: surface seen at 65 deg or less, rms", error, "mm", 2.0, "goal <=")
    far = 100.0 * float(np.concatenate(slanted).mean())
    yield Row("same: farther off than 5 mm", far, "%")
    yield Row("same: a view's place, 1 m over the floor, rms", rms(np.array(apart)), "mm")
    yield Row(
        "same: true landmarks of two views apart, rms", rms(np.array(landmarks)), "mm", 2.0, "goal"
    )
    yield Row("same: not joined", float(n_refused), f"of {len(seeds)}")
    yield from girths.rows(name)


def _sways(seed: int, sway: float) -> list[RigidTransform]:
    """Return how the body stands otherwise in each view: a lean and a shift of the given size."""
    rng = np.random.default_rng([seed, 0x5A])
    motions = []
    for number in range(len(VIEWS)):
        lean, aside = rng.normal(size=3), rng.normal(size=3)
        aside[1] = 0.0
        turn = sway * SWAY_RAD * lean / np.linalg.norm(lean)
        shift_m = sway * SWAY_M * aside / np.linalg.norm(aside)
        if number == 0:
            turn, shift_m = 0.0 * turn, 0.0 * shift_m
        motions.append(
            RigidTransform(
                about(LEFT, turn[0]) @ about(DOWN, turn[1]) @ about(FORWARD, turn[2]), shift_m
            )
        )
    return motions


def _seen(
    scene: BackScene,
    view: View,
    seed: int,
    sway: float = 0.0,
    motion: RigidTransform | None = None,
    n_frames: int | None = None,
) -> BodyView:
    """Return a view of as many frames as the window takes, or of `n_frames`."""
    n_frames = n_frames or frames_of_view(view, N_FRAMES)
    posed = scene.posed(view)
    if sway and motion is not None:
        heading = about(DOWN, HEADINGS_RAD[view])
        vertices_m = motion.apply(posed.vertices_m @ heading) @ heading.T
        posed = replace(posed, vertices_m=vertices_m)
    calibration: RgbdCalibration = scene.calibration
    surface = fuse_depth(
        burst(scene, posed, n_frames, seed),
        calibration.depth_bias,
        calibration.depth,
        least_share=LEAST_SHARE,
    )
    return person_in(view, surface, calibration)


def _off_mm(scene: BackScene, whole: WholeBody) -> FloatArray:
    """Return signed distances of the surface from the true mesh as the first view saw it."""
    posed = scene.posed("posterior")
    axes = whole.patient_from_camera["posterior"]
    vertices_m = axes.apply(scene.depth_from_world.apply(posed.vertices_m))
    triangles = scene.patient.body.model.triangles
    return distances_mm(whole.surface.points_m, vertices_m, triangles)


def _poses(
    scene: BackScene, whole: WholeBody, motions: Sequence[RigidTransform]
) -> tuple[list[float], list[float]]:
    """Return how far each further view lies wrong, and its landmarks from the first view's, mm."""
    first = whole.patient_from_camera["posterior"] @ scene.depth_from_world
    marks = scene.posed("posterior").landmarks
    apart, landmarks = [], []
    for view, motion in list(zip(VIEWS, motions, strict=True))[1:]:
        heading = about(DOWN, HEADINGS_RAD["posterior"]) @ about(DOWN, HEADINGS_RAD[view]).T
        back = about(DOWN, HEADINGS_RAD[view])
        swayed = RigidTransform(back, np.zeros(3)) @ motion @ RigidTransform(back.T, np.zeros(3))
        true = first @ RigidTransform(heading, np.zeros(3)) @ swayed.inverse()
        found = whole.patient_from_camera[view] @ scene.depth_from_world
        error = found @ true.inverse()
        middle_m = np.array([0.0, 1.0, 0.0])
        apart.append(1e3 * float(np.linalg.norm(error.apply(middle_m) - middle_m)))
        for name in LANDMARKS:
            place_m = first.apply(marks[name])
            landmarks.append(1e3 * float(np.linalg.norm(error.apply(place_m) - place_m)))
    return apart, landmarks
