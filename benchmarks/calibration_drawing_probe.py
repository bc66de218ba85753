"""Started as a process of its own: prints the seconds that drawing a frame with a board takes.

Usage: ``python -m benchmarks.calibration_drawing_probe ROUNDS``.
"""

import os
import sys
import tempfile
import time
from pathlib import Path

N_FRAMES = 4


def main() -> None:
    """Show frames of the wizard, and count the CPU time of all that the window does with them."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from PySide6.QtWidgets import QApplication

    import ui  # noqa: F401  (sets OpenCV up before it is loaded)

    app = QApplication([])
    from adibas.calibration.kept import KeptCalibrations
    from adibas.pipeline.calibration_session import CalibrationSession
    from adibas.pipeline.sensor_calibration import CalibratedSensor
    from adibas.simulation.boards_scenes import BoardScene, BoardSceneSettings
    from benchmarks.calibration_wizard import BOARD, live_frames
    from ui.calibration.ports import Shown
    from ui.calibration.view import CalibrationScreen

    frames = live_frames(N_FRAMES)
    sensor = CalibratedSensor("probe", (1280, 1024), BoardScene(BoardSceneSettings()).info)
    screen = CalibrationScreen()
    screen.resize(1168, 764)
    screen.show()
    with tempfile.TemporaryDirectory() as folder:
        session = CalibrationSession(sensor, KeptCalibrations(Path(folder)), BOARD)
        for picture in filter(None, map(session.picture, frames)):
            session.add(session.keep(picture))
        moments = [session.see(frame) for frame in frames]
        screen.show_session(Shown(BOARD, session.pictures, session.guidance))
        start_s = 0.0
        n_rounds = int(sys.argv[1])
        for index in range(N_FRAMES + n_rounds):
            if index == N_FRAMES:
                start_s = time.process_time()
            screen.show_frame(frames[index % N_FRAMES], moments[index % N_FRAMES])
            app.processEvents()
        sys.stdout.write(f"{(time.process_time() - start_s) / n_rounds:.6f}\n")
    screen.close()


if __name__ == "__main__":
    main()
