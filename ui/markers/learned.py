"""What the learner knows so far: settings, clicks on the picture that is held still, colours."""

from collections.abc import Callable
from dataclasses import replace

from adibas.arrays import BoolArray
from adibas.markers.color_model import ColorModel, LearningParams
from adibas.markers.lab import lab_to_rgb
from adibas.markers.led import LedParams
from adibas.pipeline.learning_board import LearnedRegion, LearningBoard, learned_model
from adibas.pipeline.posture import MarkerTarget
from ui.markers.ports import Mode, Shown


class Learned:
    """Colours come from the clicks on a board, or from a file; an LED is told by its brightness.

    Attributes
    ----------
    mode : str
        ``color`` or ``led``: which of both is looked for.
    led : LedParams
        How bright an LED is.
    model : ColorModel or None
        The colours; of a search that is still running they are those before.
    board : LearningBoard or None
        The picture that can be clicked on; None while it is being made ready.
    """

    def __init__(self) -> None:
        self.mode: Mode = "color"
        self.led = LedParams()
        self.model: ColorModel | None = None
        self.board: LearningBoard | None = None
        self._params = LearningParams()

    @property
    def params(self) -> LearningParams:
        """How colours are learned from clicks."""
        return self._params

    @property
    def target(self) -> MarkerTarget | None:
        """What markers look like, as far as it is known."""
        return self.led if self.mode == "led" else self.model

    @property
    def has_clicks(self) -> bool:
        """Whether anything was clicked on this picture."""
        return self.board is not None and bool(self.board.regions)

    def take_target(self, target: MarkerTarget) -> None:
        """Go on with markers that were learned elsewhere."""
        if isinstance(target, LedParams):
            self.mode, self.led = "led", target
        else:
            self.mode, self.model = "color", target

    def take_board(self, board: LearningBoard) -> None:
        """Take clicks on this picture from now on."""
        board.params = self._params
        self.board = board

    def set_sensitivity(self, sensitivity: float) -> None:
        """Let the last region, and those to come, be as large as that."""
        self._params = replace(self._params, sensitivity=sensitivity)
        if self.board is not None:
            self.board.set_sensitivity(sensitivity)

    def set_clusters(self, n_clusters: int) -> None:
        """Learn so many colours."""
        self._params = replace(self._params, n_clusters=n_clusters)
        if self.board is not None:
            self.board.set_clusters(n_clusters)

    def set_brightness(self, least_brightness: float) -> None:
        """Take for an LED what is so much brighter than the scene."""
        self.led = replace(self.led, least_brightness=least_brightness)

    def discard(self, index: int) -> None:
        """Take the region of one click away; with the last one the colours go."""
        if self.board is not None:
            self.board.discard(index)
            if not self.board.regions:
                self.model = None

    def forget_clicks(self) -> None:
        """Go on without regions, with the markers that are known."""
        if self.board is not None:
            self.take_board(self.board.without_regions())

    def reset(self) -> None:
        """Forget colours and settings, and what was clicked."""
        self._params, self.led, self.model = LearningParams(), LedParams(), None
        self.forget_clicks()

    def taken(self) -> BoolArray | None:
        """Return the (H, W) pixels that the clicks took; None where colours do not matter."""
        return self.board.taken() if self.board is not None and self.mode == "color" else None

    def learning(self) -> Callable[[], ColorModel | None]:
        """Return what learns the colours of the regions; without any, those that are known stay."""
        board, model = self.board, self.model
        if board is None or not board.regions:
            return lambda: model
        lab, regions, params = board.lab, board.regions, board.params
        return lambda: learned_model(lab, regions, params)

    def shown(self, *, has_picture: bool) -> Shown:
        """Return what the controls show of it."""
        regions = self.board.regions if self.board is not None else ()
        return Shown(
            mode=self.mode,
            sensitivity=self._params.sensitivity,
            n_clusters=self._params.n_clusters,
            least_brightness=self.led.least_brightness,
            regions=tuple((_rgb(region), region.n_pixels) for region in regions),
            swatches=() if self.model is None else _colors(self.model),
            has_picture=has_picture,
            has_target=self.target is not None,
        )


def _rgb(region: LearnedRegion) -> tuple[int, int, int]:
    red, green, blue = region.mean_rgb.tolist()
    return red, green, blue


def _colors(model: ColorModel) -> tuple[tuple[int, int, int], ...]:
    colors = lab_to_rgb(model.centroids_lab)
    return tuple((red, green, blue) for red, green, blue in colors.tolist())
