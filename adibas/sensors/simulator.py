"""The simulated clinic as a camera."""

from collections import deque
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import SensorError
from adibas.sensors.pace import Pacer
from adibas.sensors.ports import DEFAULT_OPTIONS, READ_TIMEOUT_S, DepthCamera, SensorOptions
from adibas.simulation.boards_scenes import BoardScene
from adibas.simulation.boards_wall import WallScene
from adibas.simulation.crowds import CrowdScene, crowd_names, open_crowd
from adibas.simulation.scenes import SimulatedScene, open_scene, scene_names

N_RENDERERS = 2
"""Frames in work side by side, ahead of `read`."""

SMALL_COLOR = (640, 480)


class SimulatorCamera(DepthCamera):
    """Gives the frames of a scene, each as soon as it is computed or at the scene's own pace.

    Every frame is computed anew, and is the same whatever was asked for before. Where the computer
    is slower than the scene's clock the frames come later than their times say, and none is left
    out.

    Parameters
    ----------
    scene : str, optional
        One of `scene_names()`, the first one by default; or of `crowd_names()`, which are several
        people and furniture in depth alone.
    options : SensorOptions
        `seed` of the noise, `is_paced`, and `color_size`: 640 x 480, or 1280 x 1024 for any other.

    Raises
    ------
    SensorError
        There is no such scene.
    """

    def __init__(self, scene: str | None = None, options: SensorOptions = DEFAULT_OPTIONS) -> None:
        names = (*scene_names(), *crowd_names())
        if scene is not None and scene not in names:
            raise SensorError(
                "The simulator has no scene {scene}. Choose one of: {scenes}.",
                scene=scene,
                scenes=", ".join(names),
            )
        self._scene = _opened(scene or names[0], options)
        self._pacer = Pacer() if options.is_paced else None
        self._next_index = 0
        self._renderers = ThreadPoolExecutor(N_RENDERERS, thread_name_prefix="simulator")
        self._ahead: deque[Future[SensorFrame]] = deque()

    @property
    def info(self) -> SourceInfo:
        """The header, with the exact calibration of the simulated sensor.

        The scenes ``board`` and ``wall`` are there to calibrate it: their header has the maker's
        calibration, which is slightly wrong (see `adibas.simulation.boards_device`).
        """
        return self._scene.info

    @property
    def is_live(self) -> bool:
        """False: the simulator waits."""
        return False

    def read(self, timeout_s: float = READ_TIMEOUT_S) -> SensorFrame | None:  # noqa: ARG002
        """Return the next frame, None at the end of the scene; `timeout_s` has no meaning here.

        Raises
        ------
        SensorError
            The simulator is closed, or the program is about to end.
        """
        self._render_ahead()
        if not self._ahead:
            return None
        try:
            frame = self._ahead.popleft().result()
        except CancelledError as error:
            raise SensorError("The simulator is closed. Open it again.") from error
        self._render_ahead()
        if self._pacer is not None:
            self._pacer.wait_for(frame.timestamp_ns)
        return frame

    def close(self) -> None:
        """Wait for the frames in work."""
        self._renderers.shutdown(cancel_futures=True)

    def _render_ahead(self) -> None:
        n_frames = self._scene.n_frames
        while len(self._ahead) < N_RENDERERS:
            if n_frames is not None and self._next_index >= n_frames:
                return
            try:
                rendered = self._renderers.submit(self._render, self._next_index)
            except RuntimeError as error:  # as they say that they take no more work
                raise SensorError("The simulator is closed. Open it again.") from error
            self._ahead.append(rendered)
            self._next_index += 1

    def _render(self, index: int) -> SensorFrame:
        return self._scene.frame(index).sensor_frame


def _opened(
    scene: str, options: SensorOptions
) -> SimulatedScene | BoardScene | WallScene | CrowdScene:
    if scene in crowd_names():
        return open_crowd(scene, options.seed)
    size = (480, 640) if options.color_size == SMALL_COLOR else (1024, 1280)
    return open_scene(scene, seed=options.seed, color_size=size)
