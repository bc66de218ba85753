"""The demo: a whole posture session of a simulated patient, on the same path as a real one."""

from dataclasses import dataclass
from pathlib import Path

from adibas.clock import Clock, utc_now
from adibas.data.posture import PostureAnalysis
from adibas.pipeline.learning import LearningRequest, learn_from_file
from adibas.pipeline.session import PostureRequest, analyse_recording
from adibas.progress import Progress
from adibas.recordings import create_recording
from adibas.recordings.ports import RecordingOptions
from adibas.simulation.scenes import SimulatedScene, open_scene
from adibas.simulation.truth import MarkerTruth

SCENE = "anterior"
SEED = 7
N_FRAMES = 30
N_CLICKS = 3
PATIENT = "demo-patient"
JPEG_QUALITY = 95


@dataclass(frozen=True, slots=True, eq=False)
class Demo:
    """Where the demo's files lie, and what was measured."""

    recording: Path
    colors: Path
    analysis: PostureAnalysis


def run_demo(
    folder: Path, progress: Progress, clock: Clock = utc_now, n_frames: int | None = None
) -> Demo:
    """Record the demo patient, learn the marker colour by clicks, analyse the burst.

    Parameters
    ----------
    n_frames : int or None
        Of the burst; None: `N_FRAMES`.

    Raises
    ------
    AdibasError
        A file cannot be written.
    """
    recording, colors = folder / "recording.mcap", folder / "colours.json"
    scene = open_scene(SCENE, seed=SEED, jpeg_quality=JPEG_QUALITY)
    n_frames = N_FRAMES if n_frames is None else n_frames
    n_steps = 2 * n_frames
    clicks = _record(scene, recording, n_frames, lambda done, _total: progress(done, n_steps))
    learn_from_file(LearningRequest(recording, clicks), colors)
    request = PostureRequest(recording=recording, markers=str(colors), view=SCENE, patient=PATIENT)
    analysis = analyse_recording(
        request, lambda done, _total: progress(n_frames + done, n_steps), clock
    )
    return Demo(recording, colors, analysis)


def _record(
    scene: SimulatedScene, path: Path, n_frames: int, progress: Progress
) -> tuple[tuple[float, float], ...]:
    """Record the scene; return where a user would click on markers in the first frame."""
    clicks: tuple[tuple[float, float], ...] = ()
    with create_recording(path, scene.info, RecordingOptions(is_live=False)) as writer:
        for index in range(n_frames):
            simulated = scene.frame(index)
            writer.write(simulated.sensor_frame)
            clicks = clicks or _clicks(simulated.truth.markers)
            progress(index + 1, n_frames)
    return clicks


def _clicks(markers: tuple[MarkerTruth, ...]) -> tuple[tuple[float, float], ...]:
    visible = [marker for marker in markers if marker.is_visible]
    facing = sorted(visible, key=lambda marker: marker.view_angle_rad)
    return tuple((marker.u, marker.v) for marker in facing[:N_CLICKS])
