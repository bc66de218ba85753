"""A sensor that is pulled out and put back while it is looked at and recorded.

``python -m benchmarks.sensor_trial N_PULLS`` with OpenNI2's virtual sensor in the environment (see
``tests/virtual_openni2``); prints a line of JSON for each pull.
"""

import json
import os
import sys
import tempfile
import threading
import time
from concurrent.futures import CancelledError
from pathlib import Path

from adibas.errors import AdibasError
from adibas.pipeline.live import LiveFrame, LiveView, SensorState
from adibas.recordings import create_recording
from adibas.sensors.ports import SensorOptions

OPTIONS = SensorOptions(color_size=(640, 480))
SECONDS_TO_COME_BACK = 60.0
MOST_FRAMES = 10_000


class Watch:
    """Waits for what the live view tells."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self.kind, self.n_frames, self.sentence = "", 0, ""

    def frame_arrived(self, _frame: LiveFrame) -> None:
        """Take a frame."""
        with self._changed:
            self.n_frames += 1
            self._changed.notify_all()

    def state_changed(self, state: SensorState) -> None:
        """Take how the sensor fares."""
        with self._changed:
            self.kind = state.kind
            self.sentence = str(state.error or "")
            self._changed.notify_all()

    def wait_for(self, kind: str) -> None:
        """Return once the sensor is in this state, and if live, has shown a frame of now."""
        with self._changed:
            before = self.n_frames
            is_so = self._changed.wait_for(
                lambda: self.kind == kind and (kind != "live" or self.n_frames > before),
                SECONDS_TO_COME_BACK,
            )
        if not is_so:
            raise TimeoutError(f"{self.kind} and not {kind}: {self.sentence}")


def main() -> None:
    """Pull the sensor, and put it back, so many times."""
    pulled = Path(f"{os.environ['ADIBAS_VIRTUAL_SENSOR']}.unplug")
    watch = Watch()
    view = LiveView(watch)
    view.open("openni2", OPTIONS)
    with tempfile.TemporaryDirectory() as folder:
        for number in range(int(sys.argv[1])):
            watch.wait_for("live")
            told = _pulled_while_recording(view, watch, pulled, Path(folder) / f"{number}.mcap")
            start_s = time.monotonic()
            pulled.unlink()
            watch.wait_for("live")
            told["seconds"] = time.monotonic() - start_s
            print(json.dumps(told | _process()), flush=True)  # noqa: T201
    view.close()
    left = [one.name for one in threading.enumerate() if one.name.startswith("live")]
    print(json.dumps({"left": left}), flush=True)  # noqa: T201


def _pulled_while_recording(
    view: LiveView, watch: Watch, pulled: Path, path: Path
) -> dict[str, object]:
    info = view.state.info
    if info is None:
        raise RuntimeError("no sensor")
    writer = create_recording(path, info)
    recorded = view.capture(MOST_FRAMES, writer)
    pulled.touch()
    watch.wait_for("lost")
    told = ""
    try:
        recorded.result(SECONDS_TO_COME_BACK)
    except (AdibasError, CancelledError) as error:
        told = str(error)
    writer.abandon()
    writer.close()
    return {"sentence": watch.sentence, "burst": told}


def _process() -> dict[str, object]:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return {
        "memory_mb": pages * os.sysconf("SC_PAGESIZE") / 2**20,
        "n_files": len(os.listdir("/proc/self/fd")),  # noqa: PTH208  (no paths are needed)
        "n_threads": threading.active_count(),
    }


if __name__ == "__main__":
    main()
