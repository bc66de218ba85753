"""The simulated clinic as a camera."""

from adibas.data.frames import SensorFrame, SourceInfo
from adibas.errors import SensorError
from adibas.sensors.pace import Pacer
from adibas.sensors.ports import DEFAULT_OPTIONS, READ_TIMEOUT_S, DepthCamera, SensorOptions
from adibas.simulation.scenes import open_scene, scene_names


class SimulatorCamera(DepthCamera):
    """Gives the frames of a scene, each as soon as it is computed or at the scene's own pace.

    Parameters
    ----------
    scene : str, optional
        One of `scene_names()`; the first one by default.
    options : SensorOptions
        `seed` of the noise, and `is_paced`.

    Raises
    ------
    SensorError
        There is no such scene.
    """

    def __init__(self, scene: str | None = None, options: SensorOptions = DEFAULT_OPTIONS) -> None:
        names = scene_names()
        if scene is not None and scene not in names:
            raise SensorError(
                "The simulator has no scene {scene}. Choose one of: {scenes}.",
                scene=scene,
                scenes=", ".join(names),
            )
        self._scene = open_scene(scene or names[0], seed=options.seed)
        self._pacer = Pacer() if options.is_paced else None
        self._next_index = 0

    @property
    def info(self) -> SourceInfo:
        """The header, with the exact calibration of the simulated sensor."""
        return self._scene.info

    @property
    def is_live(self) -> bool:
        """False: the simulator waits."""
        return False

    def read(self, timeout_s: float = READ_TIMEOUT_S) -> SensorFrame | None:  # noqa: ARG002
        """Return the next frame, None at the end of the scene; `timeout_s` has no meaning here."""
        n_frames = self._scene.n_frames
        if n_frames is not None and self._next_index >= n_frames:
            return None
        frame = self._scene.frame(self._next_index).sensor_frame
        self._next_index += 1
        if self._pacer is not None:
            self._pacer.wait_for(frame.timestamp_ns)
        return frame

    def close(self) -> None:
        """Nothing to give back."""
