"""Somebody who turns around before the sensor, as depth images and as recordings."""

import functools
from dataclasses import replace

import numpy as np

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.recordings import RecordingOptions, create_recording
from adibas.simulation.depth_noise import DepthNoise, DepthSensor
from adibas.simulation.patient import MarkerSettings
from adibas.simulation.poses import HEADINGS_RAD
from adibas.simulation.room import draw_room
from adibas.simulation.studio import DepthStudio
from benchmarks.body_scenes import draw_back_scene

STEP_DEG, N_FRAMES = 6.0, 64
PERIOD_NS = 33_000_000


@functools.cache
def turning_scene():
    return draw_back_scene(1, is_portrait=True)


def posed(scene, number, way):
    turn_rad = np.radians(way * STEP_DEG * number)
    heading_rad = HEADINGS_RAD["posterior"] + turn_rad
    return scene.patient.body.posed(replace(scene.pose, heading_rad=heading_rad))


def drawn(scene, n_frames, way):
    """Return the raw depth of a turn; the turn about the axis that points down is to the right."""
    studio = DepthStudio(
        draw_room(np.random.default_rng(1)), scene.depth_from_world, scene.device.depth
    )
    sensor = DepthSensor(scene.device, DepthNoise(), 1)
    images = []
    for number in range(n_frames):
        view = studio.view(scene.patient, posed(scene, number, way), MarkerSettings())
        images.append(sensor.measure(view.inverse_depth, view.reflectance, number, None))
    return images


@functools.cache
def turn_images():
    """Return the raw depth of one whole turn to the right."""
    return drawn(turning_scene(), N_FRAMES, 1)


def turn_info(scene, **changes):
    return SourceInfo(calibration=replace(scene.calibration, **changes), depth_unit_m=0.001)


def turn_frames(images):
    """Return sensor frames; None becomes a frame with colour alone."""
    for number, raw in enumerate(images):
        time_ns = 1 + number * PERIOD_NS
        color = None if raw is not None else np.zeros((48, 64, 3), np.uint8)
        stamp = None if color is None else time_ns
        yield SensorFrame(number, time_ns, raw, color, stamp)


def write(path, images, scene, **changes):
    with create_recording(
        path, turn_info(scene, **changes), RecordingOptions(is_live=False)
    ) as recording:
        for frame in turn_frames(images):
            recording.write(frame)
    return path


def add_turn(store, session, images):
    """Add a recording of a turn to a session; return it."""
    scene = turning_scene()
    with store.recordings.create(session.session_id, turn_info(scene)) as writer:
        for frame in turn_frames(images):
            writer.write(frame)
    setup = replace(session.setup, turn=writer.recording_id)
    return store.sessions.change(session.session_id, setup=setup)
