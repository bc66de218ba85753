"""Maps one recording beside the window, and saves what came of it. Knows nothing of Qt."""

from collections.abc import Callable
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING

from adibas.errors import AdibasError
from adibas.texts import translate as _
from ui.mapping.content import MapView, RecordingToMap, Standing, space_of, told_of
from ui.ports import Job, JobControl
from ui.workspace import Workspace

if TYPE_CHECKING:  # they bring the compiler along, and the window does without at its start
    from adibas.pipeline.map_preview import MapPicture
    from adibas.pipeline.map_state import MapMemory
    from adibas.pipeline.mapping import MappedRecording


class MapPresenter:
    """Starts, stops and goes on; what is unfinished is in memory alone, and goes with the dialog.

    Parameters
    ----------
    recording : RecordingToMap
    """

    def __init__(self, view: MapView, workspace: Workspace, recording: RecordingToMap) -> None:
        self._view = view
        self._workspace = workspace
        self._recording = recording
        self._memory: MapMemory | None = None
        self._lock = Lock()
        self._picture: MapPicture | None = None
        self._reached = (0, 0)
        self._job: Job | None = None
        self._has_begun = False
        self._mapped: MappedRecording | None = None
        self._is_closed = False
        self._show_standing()

    def start(self, *, is_body: bool) -> None:
        """Map, or go on where it was stopped.

        Parameters
        ----------
        is_body : bool
            The person alone.
        """
        if self._is_busy:
            return
        self._mapped = None
        self._has_begun = True
        self._view.show_told((), is_problem=False)
        self._job = self._workspace.jobs.start(
            _("Mapping"), self._work(is_body=is_body), self._on_mapped, self._on_failed, self._ended
        )
        self._show_standing()

    def stop(self) -> None:
        """Stop; what was found is kept for going on."""
        if self._job is not None:
            self._job.cancel()

    def look(self) -> None:
        """Show what the job has come to; asked at times, in the window's thread."""
        if not self._is_busy:
            return
        with self._lock:
            picture, self._picture = self._picture, None
            reached = self._reached
        self._view.show_progress(*reached)
        if picture is not None:
            self._view.show_growing(space_of(picture))

    @property
    def name(self) -> str:
        """What files are called after."""
        return self._recording.name

    def save_surface(self, path: Path) -> None:
        """Write the surface as PLY."""
        from adibas.reports.map_files import write_ply

        self._save(path, lambda mapped: write_ply(mapped.surface, path))

    def save_path(self, path: Path) -> None:
        """Write the path of the camera in TUM's format."""
        from adibas.reports.map_files import write_trajectory

        self._save(path, lambda mapped: write_trajectory(mapped, path))

    def close(self) -> None:
        """Give up what runs, and forget what is unfinished."""
        self._is_closed = True
        self.stop()
        self._memory = None

    @property
    def _is_busy(self) -> bool:
        return self._job is not None and self._job.is_running

    def _work(self, *, is_body: bool) -> "Callable[[JobControl], MappedRecording]":
        recording = self._recording

        def work(control: JobControl) -> "MappedRecording":
            from adibas.pipeline.map_state import MapMemory
            from adibas.pipeline.mapping import MapRequest, map_recording

            memory = self._memory = self._memory or MapMemory()

            def progress(done: int, total: int) -> None:
                with self._lock:
                    self._reached = (done, total)
                control.progress(done, total)

            def watch(picture: "MapPicture") -> None:
                with self._lock:
                    self._picture = picture

            request = MapRequest(
                recording.path, is_body=is_body, memory=memory, access=recording.access
            )
            return map_recording(request, progress, watch)

        return work

    def _on_mapped(self, mapped: "MappedRecording") -> None:
        if self._is_closed:
            return
        self._mapped = mapped
        self._show_standing()
        self._view.show_told(tuple(sentence.text for sentence in told_of(mapped)), is_problem=False)

    def _on_failed(self, error: AdibasError) -> None:
        if self._is_closed:
            return
        self._has_begun = False
        self._show_standing()
        self._view.show_told((str(error),), is_problem=True)

    def _ended(self) -> None:
        if self._is_closed:
            return
        with self._lock:
            picture, self._picture = self._picture, None
        if picture is not None:
            self._view.show_growing(space_of(picture))
        self._show_standing()

    def _save(self, path: Path, write: "Callable[[MappedRecording], None]") -> None:
        mapped = self._mapped
        if mapped is None:
            return
        try:
            self._recording.note_export()
            write(mapped)
        except AdibasError as error:
            self._view.show_told((str(error),), is_problem=True)
        else:
            told = _("{file} was saved.").format(file=path.name)
            self._view.show_told((told,), is_problem=False)

    def _show_standing(self) -> None:
        has_map = self._mapped is not None
        self._view.show_standing(Standing(self._is_busy, self._has_begun and not has_map, has_map))
