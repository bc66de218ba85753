"""The board of the simulator, as somebody holds it who is in a hurry."""

from dataclasses import replace

from adibas.data.frames import SourceInfo
from adibas.simulation.boards_scenes import BoardScene, BoardSceneSettings
from adibas.simulation.frame_times import frame_time_ns
from adibas.simulation.scenes import open_scene

SMALL = (480, 640)
STILL_EVERY, FRAMES_A_STOP = 3, 8
"""Ten frames a second for 0.7 s tell that the board is held still, some of them missed."""


class HurriedScene:
    """The board of the simulator at its stops alone, and at each for so many frames.

    What is left out the wizard would pass over; each picture is the scene's own.
    """

    def __init__(self, scene, still_every=STILL_EVERY, frames_a_stop=FRAMES_A_STOP):
        self._every = still_every
        self._scene = scene
        self.info: SourceInfo = scene.info
        self.device = scene.device
        self._kept = self._frames_to_keep(frames_a_stop)
        self.n_frames = len(self._kept)

    def _frames_to_keep(self, frames_a_stop):
        seed, walk = self._scene.settings.seed, self._scene.walk
        first_ns = frame_time_ns(seed, 0)
        by_stop = {}
        for index in range(0, round(walk.duration_s * 30), self._every):
            stop = walk.station_at((frame_time_ns(seed, index) - first_ns) * 1e-9)
            if stop is not None:
                by_stop.setdefault(stop, []).append(index)
        return [index for stop in by_stop.values() for index in stop[:frames_a_stop]]

    def frame(self, index):
        simulated = self._scene.frame(self._kept[index])
        time_ns = round(index * self._every * 1e9 / 30)
        frame = replace(
            simulated.sensor_frame,
            sequence=index,
            timestamp_ns=time_ns,
            color_timestamp_ns=time_ns,
        )
        return replace(simulated, sensor_frame=frame)


def hurried_scene(name, seed=0, still_every=STILL_EVERY, frames_a_stop=FRAMES_A_STOP, **changes):
    """Open a scene of the simulator with small colour images, and a board that hurries."""
    changes["color_size"] = SMALL
    if name != "board":
        return open_scene(name, seed, **changes)
    board = BoardScene(replace(BoardSceneSettings(seed), **changes))
    return HurriedScene(board, still_every, frames_a_stop)
