"""Learning colours and looking for markers, beside the window; the newest wish counts."""

from collections.abc import Callable

from adibas.markers.color_model import ColorModel
from adibas.markers.detection import DetectionParams, Detections
from adibas.markers.led import LedParams
from adibas.pipeline.frozen import FrozenPicture
from adibas.pipeline.posture import MarkerTarget
from adibas.texts import translate as _
from ui.markers.learned import Learned
from ui.ports import Job, JobControl
from ui.workspace import Workspace


class MarkerSearch:
    """While one search runs, the newest wish waits; those between are never begun.

    Parameters
    ----------
    workspace : Workspace
        Whose jobs it runs as.
    learned : Learned
        What to learn from and to look for, as it is when a search begins.
    found : callable
        Told of the colours and the markers, None for neither.
    """

    def __init__(
        self,
        workspace: Workspace,
        learned: Learned,
        found: Callable[[ColorModel | None, Detections | None], None],
    ) -> None:
        self._workspace = workspace
        self._learned = learned
        self._found = found
        self._job: Job | None = None
        self._next: FrozenPicture | None = None

    @property
    def is_running(self) -> bool:
        """Whether something is still to be found."""
        return self._job is not None and self._job.is_running

    def begin(self, picture: FrozenPicture) -> None:
        """Learn, and look for markers in a picture."""
        if self.is_running:
            self._next = picture
        else:
            self._start(picture)

    def stop(self) -> None:
        """Want no more what a running search will find."""
        self._next = None
        if self._job is not None and self._job.is_running:
            self._job.cancel()

    def _start(self, picture: FrozenPicture) -> None:
        learn, params = self._learned.learning(), DetectionParams()
        led: LedParams | None = self._learned.led if self._learned.mode == "led" else None

        def work(_control: JobControl) -> tuple[ColorModel | None, Detections | None]:
            model = learn()
            target: MarkerTarget | None = led or model
            return model, None if target is None else picture.find(target, params)

        self._next = None
        self._job = self._workspace.jobs.start(
            _("Looking for markers"), work, self._on_found, ended=self._on_ended
        )

    def _on_found(self, result: tuple[ColorModel | None, Detections | None]) -> None:
        self._found(*result)

    def _on_ended(self) -> None:
        if self._next is not None:
            self._start(self._next)
