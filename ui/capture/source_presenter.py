"""Which sensor is shown, and how it stands. Knows nothing of Qt."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

from adibas.data.posture import VIEWS
from adibas.data.sessions import SessionSetup
from adibas.sensors.ports import SensorOptions
from adibas.sensors.sources import is_sensor
from adibas.texts import translate as _
from ui.capture.ports import CaptureView
from ui.capture.sources import (
    SIMULATOR,
    SourceChoice,
    find_sources,
    source_for_view,
    usual_sources,
)
from ui.ports import JobControl
from ui.view_names import TURN
from ui.workspace import Workspace

MOST_RECENT = 8

Look = Callable[[tuple[str, ...]], tuple[SourceChoice, ...]]


class SourcePresenter:
    """Offers sources, opens the one in use, and keeps the choice with the session.

    Parameters
    ----------
    may_change : callable
        Asked before the user's wish is followed; tells him why not.
    may_open : callable
        Whether a source may be opened now.
    look : callable
        Looks for sensors, in a job; given the recent recordings.

    Attributes
    ----------
    setup : SessionSetup
        In use.
    """

    def __init__(
        self,
        view: CaptureView,
        workspace: Workspace,
        may_change: Callable[[], bool],
        may_open: Callable[[], bool],
        look: Look = find_sources,
    ) -> None:
        self._view = view
        self._workspace = workspace
        self._may_change = may_change
        self._may_open = may_open
        self._look = look
        self._has_looked = False
        self._view_name = VIEWS[0]
        self.setup = SessionSetup()
        self._recent: tuple[str, ...] = ()  # on no disk: a name of a file can be a patient's
        self._show(usual_sources(self._recent))

    def look_once(self) -> None:
        """Look which sensors are plugged in, unless that was done."""
        if not self._has_looked:
            self._start_looking(self._show)

    def look_for_sources(self) -> None:
        """Look anew, because the user wants it."""
        self._start_looking(self._show_found)

    def choose_source(self, source: str) -> None:
        """Show another sensor, the simulator, or a recording."""
        if self._may_change():
            self._change(replace(self.setup, source=source, wand=None))

    def open_recording(self, path: Path) -> None:
        """Replay a recording as if it were a sensor."""
        if self._may_change():
            others = (one for one in self._recent if one != str(path))
            self._recent = (str(path), *others)[:MOST_RECENT]
            self._change(replace(self.setup, source=str(path), wand=None))
            self._show(usual_sources(self._recent))

    def choose_size(self, color_size: tuple[int, int]) -> None:
        """Ask the sensor for another size of its colour image."""
        if self._may_change():
            self._change(replace(self.setup, color_size=color_size))

    def turn(self) -> None:
        """Turn the picture by a quarter, for a sensor mounted on its side."""
        rotation_deg = (self.setup.rotation_deg + 90) % 360
        self._change(replace(self.setup, rotation_deg=rotation_deg))

    def note_wand(self, document: Mapping[str, object]) -> None:
        """Keep a check with a wand with the session, or with the next one that is started."""
        self._change(replace(self.setup, wand=document))

    def use(self, setup: SessionSetup) -> None:
        """Use this set-up from now on."""
        self.setup = setup
        self._show_setup()

    def open(self, view_name: str) -> None:
        """Open what is wanted for a view, unless it is open, or nothing may be opened now."""
        if view_name != self._view_name:
            self._view_name = view_name
            self._show_setup()
        if not self._may_open():
            return
        wanted = (source_for_view(self.setup.source, view_name), self._options)
        live = self._workspace.live
        if live.opened != wanted or live.state.kind in ("closed", "ended"):
            live.open(*wanted)

    def begin_anew(self) -> bool:
        """Open a recording or the simulator from its beginning; False: a sensor has none."""
        source = self.setup.source
        if is_sensor(source):
            return False
        self._workspace.live.open(source_for_view(source, self._view_name), self._options)
        return True

    def _show_setup(self) -> None:
        """Show the set-up; for a turn the demo sensor lies on its side, to see a whole person."""
        is_on_its_side = (self.setup.source, self._view_name) == (SIMULATOR, TURN)
        rotation_deg = (self.setup.rotation_deg + 90 * is_on_its_side) % 360
        self._workspace.live.set_rotation(rotation_deg)
        self._view.show_setup(replace(self.setup, rotation_deg=rotation_deg))

    @property
    def _options(self) -> SensorOptions:
        width, height = self.setup.color_size
        return SensorOptions(color_size=(width, height))

    def _start_looking(self, show: Callable[[tuple[SourceChoice, ...]], None]) -> None:
        self._has_looked = True
        recent = self._recent

        def work(_control: JobControl) -> tuple[SourceChoice, ...]:
            return self._look(recent)

        self._workspace.jobs.start(_("Looking for sensors"), work, show)

    def _show(self, choices: tuple[SourceChoice, ...]) -> None:
        self._view.show_sources(choices, self.setup.source)
        self._show_setup()  # now that its sizes are known

    def _show_found(self, choices: tuple[SourceChoice, ...]) -> None:
        self._show(choices)
        if not any(choice.is_sensor for choice in choices):
            nothing = _("No sensor was found. Plug it in, wait a moment, and look again.")
            self._workspace.tell("warning", nothing)

    def _change(self, setup: SessionSetup) -> None:
        """Use another set-up, and keep it with the session, which tells us to use it."""
        workspace, session = self._workspace, self._workspace.session
        self.setup = setup
        if session is not None and not workspace.store.is_read_only:
            change = partial(
                workspace.store.sessions.change, session.session_id, setup=setup, seen=session
            )
            if workspace.save_shared(
                lambda decisions: workspace.renew_session(change(decisions=decisions))
            ):
                return
        self.use(setup)
        self.open(self._view_name)
