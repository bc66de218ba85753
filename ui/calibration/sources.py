"""Which source is calibrated, and which one the other screens show. Knows nothing of Qt."""

from adibas.data.sessions import SessionSetup
from adibas.sensors.ports import SensorOptions
from ui.workspace import Workspace

SIMULATOR, SIMULATED_BOARD = "simulator", "simulator:board"
Opened = tuple[str, SensorOptions]


def usual_source(workspace: Workspace) -> Opened:
    """Return the source that the other screens show: what was opened last, or the session's."""
    opened = workspace.live.opened
    if opened is not None and opened[0] != SIMULATED_BOARD:
        return opened
    setup = SessionSetup() if workspace.session is None else workspace.session.setup
    width, height = setup.color_size
    return setup.source, SensorOptions(color_size=(width, height))


def source_to_calibrate(workspace: Workspace) -> Opened:
    """Return the same sensor; in the simulator somebody carries a board about before it."""
    source, options = usual_source(workspace)
    is_simulator = source.partition(":")[0] == SIMULATOR
    return (SIMULATED_BOARD if is_simulator else source), options
