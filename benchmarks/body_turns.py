"""Simulated people who turn once around before the sensor, joined into one surface.

Once as a statue on a turntable; once on their own feet: they sway, and lift one foot after the
other. The program is told nothing but the recording.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from adibas.arrays import FloatArray
from adibas.clock import NS_PER_S
from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import BodyError
from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.back import measure_back
from adibas.pipeline.body_views import ViewRequest
from adibas.pipeline.turning import SeenTurn, see_turn
from adibas.pipeline.whole_body import join_body
from adibas.recordings import RecordingOptions, create_recording
from adibas.simulation.body import PosedBody
from adibas.simulation.depth_noise import DepthNoise, DepthSensor
from adibas.simulation.patient import MarkerSettings
from adibas.simulation.poses import DOWN, FORWARD, HEADINGS_RAD, LEFT, LegPose
from adibas.simulation.room import draw_room
from adibas.simulation.rotations import about
from adibas.simulation.studio import DepthStudio
from adibas.surface.course_errors import rms
from benchmarks.body_scenes import BackScene, draw_back_scene, true_midline_m
from benchmarks.body_truth import distances_mm, smoothed_truth
from benchmarks.table import Row

RATE_HZ, TURN_S, LAST_S = 30.0, 20.0, 21.5
SWAY_S, SWAY_M, SWAY_RAD = 1.0, 0.004, np.radians(0.5)
"""How fast it changes, and its standard deviations."""
STEP_HZ, LIFTED_RAD = 0.7, np.radians(12.0)
HIPS = 0.5
"""Share of the stature; below it the legs step."""
FAR_MM = 5.0


@dataclass(frozen=True, slots=True, eq=False)
class Turning:
    """How somebody stands in each frame.

    Attributes
    ----------
    scene : BackScene
    sway : sequence of RigidTransform
        Of the whole body, by frame.
    steps : bool
        The feet are lifted.
    """

    scene: BackScene
    sway: tuple[RigidTransform, ...]
    steps: bool

    def posed(self, frame: int) -> PosedBody:
        """Return the body of a frame, world axes."""
        time_s = frame / RATE_HZ
        heading_rad = HEADINGS_RAD["posterior"] + 2.0 * np.pi * time_s / TURN_S
        pose = replace(self.scene.pose, heading_rad=heading_rad)
        if self.steps:
            swing = LIFTED_RAD * np.sin(2.0 * np.pi * STEP_HZ * time_s)
            left, right = max(swing, 0.0), max(-swing, 0.0)
            pose = replace(
                pose,
                left_leg=_lifted(pose.left_leg, left),
                right_leg=_lifted(pose.right_leg, right),
            )
        body = self.scene.patient.body.posed(pose)
        return replace(body, vertices_m=self.sway[frame].apply(body.vertices_m))


def turn_rows(seeds: range) -> Iterator[Row]:
    """Measure both kinds."""
    yield from _rows(seeds, "a statue", steps=False, sway=0.0)
    yield from _rows(seeds, "somebody who sways and steps", steps=True, sway=1.0)


def _rows(seeds: range, told: str, *, steps: bool, sway: float) -> Iterator[Row]:
    everywhere, above, angles, counts, n_refused = [], [], [], [], 0
    for seed in seeds:
        turning = _draw(seed, steps=steps, sway=sway)
        try:
            seen = _seen(turning, seed)
            off_mm, heights = _surface(turning, seen)
        except BodyError:
            n_refused += 1
            continue
        everywhere.append(off_mm)
        above.append(off_mm[heights >= HIPS])
        counts.append(np.mean([view.n_frames for view in seen.views]))
        angles += _spine(turning, seen)
    name = f"slow turn of {told}, {TURN_S:.0f} s, seeds {seeds[0]}-{seeds[-1]}"
    yield Row(f"{name}: surface above the hips, rms", rms(np.concatenate(above)), "mm", 2.0, "goal")
    far = 100.0 * float((np.abs(np.concatenate(above)) > FAR_MM).mean())
    yield Row("same: farther off than 5 mm", far, "%")
    yield Row("same: the whole body's surface, rms", rms(np.concatenate(everywhere)), "mm")
    yield Row("same: kyphosis and lordosis, rms", rms(np.array(angles)), "deg", 2.0, "goal")
    yield Row("same: frames of a view, mean", float(np.mean(counts)), "")
    yield Row("same: refused", float(n_refused), f"of {len(seeds)}")


def _draw(seed: int, *, steps: bool, sway: float) -> Turning:
    rng = np.random.default_rng([seed, 0x7B])
    keep = np.exp(-1.0 / (RATE_HZ * SWAY_S))
    state, motions = np.zeros(5), []
    for _ in range(round(RATE_HZ * LAST_S)):
        state = keep * state + np.sqrt(1.0 - keep**2) * rng.normal(size=5)
        lean = sway * SWAY_RAD * state[:3]
        turn = about(LEFT, lean[0]) @ about(DOWN, lean[1]) @ about(FORWARD, lean[2])
        aside_m = sway * SWAY_M * state[3:]
        motions.append(RigidTransform(turn, np.array([aside_m[0], 0.0, aside_m[1]])))
    return Turning(draw_back_scene(seed, is_portrait=True), tuple(motions), steps)


def _lifted(leg: LegPose, angle_rad: float) -> LegPose:
    """Return a leg whose knee comes forward, and whose foot hangs under it."""
    forward, back = about(LEFT, -angle_rad), about(LEFT, angle_rad)
    return replace(leg, upper=forward @ leg.upper, lower=back @ leg.lower)


def _seen(turning: Turning, seed: int) -> SeenTurn:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "turn.mcap"
        _record(path, turning, seed)
        return see_turn(ViewRequest("posterior", path), lambda _done, _total: None)


def _record(path: Path, turning: Turning, seed: int) -> None:
    scene = turning.scene
    room = draw_room(np.random.default_rng([seed, 0x5C]))
    studio = DepthStudio(room, scene.depth_from_world, scene.device.depth)
    sensor = DepthSensor(scene.device, DepthNoise(), seed)
    info = SourceInfo(
        calibration=scene.calibration, depth_unit_m=scene.device.calibration.depth_unit_m
    )
    with create_recording(path, info, RecordingOptions(is_live=False)) as recording:
        for frame in range(len(turning.sway)):
            view = studio.view(scene.patient, turning.posed(frame), MarkerSettings())
            raw = sensor.measure(view.inverse_depth, view.reflectance, frame, None)
            time_ns = NS_PER_S + round(frame * NS_PER_S / RATE_HZ)
            recording.write(SensorFrame(frame, time_ns, raw, None, None))


def _surface(turning: Turning, seen: SeenTurn) -> tuple[FloatArray, FloatArray]:
    """Return the errors of the surface's points and their heights, as shares of the stature."""
    whole = join_body(seen.views)
    scene, body = turning.scene, turning.posed(seen.frames["posterior"])
    axes = whole.patient_from_camera["posterior"] @ scene.depth_from_world
    points_m = whole.surface.points_m
    off_mm = distances_mm(points_m, axes.apply(body.vertices_m), scene.patient.body.model.triangles)
    return off_mm, points_m[:, 1] / points_m[:, 1].max()


def _spine(turning: Turning, seen: SeenTurn) -> list[float]:
    """Return the errors of kyphosis and lordosis, degrees; none where no curves are found."""
    scene = turning.scene
    (view,) = [one for one in seen.views if one.view == "posterior"]
    back = measure_back(view)
    if back.shape is None:
        return []
    midline_m = back.patient_from_camera.apply(
        scene.depth_from_world.apply(true_midline_m(scene, turning.posed(seen.frames["posterior"])))
    )
    truth = smoothed_truth(midline_m, back.stature_m, back.profile.top_m).values()[:2]
    found = np.degrees([one.value for one in back.measures[:2] if one.value is not None])
    return [float(error) for error in found - truth]
