"""Bland and Altman's plot: the difference of two measurements of a patient by their mean."""

from typing import TYPE_CHECKING

from PySide6.QtWidgets import QWidget

from adibas.data.protocols import MeasureDefinition
from adibas.data.reliability import Agreement
from adibas.texts import translate as _
from ui.theme import Theme
from ui.widgets.plot import Plot, spread
from ui.widgets.rows import number

if TYPE_CHECKING:
    from pyqtgraph import PlotWidget

PADDING = 0.08


class AgreementPlot(Plot):
    """A dot for each patient, the bias and the limits of agreement, each with its 95 %."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(theme, parent)
        self._agreement: Agreement | None = None
        self._definition: MeasureDefinition | None = None

    @property
    def n_points(self) -> int:
        return 0 if self._agreement is None else len(self._agreement.means)

    def show_agreement(
        self, agreement: Agreement | None, definition: MeasureDefinition | None
    ) -> None:
        """Show the pairs of one measure; None where there are none."""
        self._agreement, self._definition = agreement, definition
        self._chosen = -1
        self.redraw()

    def redraw(self) -> None:
        """Draw anew, and say the same in words to who cannot see it."""
        super().redraw()
        self.setAccessibleDescription(agreement_text(self._agreement))

    def draw(self, plot: "PlotWidget") -> None:
        found, definition, tokens = self._agreement, self._definition, self._theme.tokens
        if found is None or definition is None:
            return
        self.add_band(plot, *found.bias_interval, tokens.accent)
        for limit, interval in zip(found.limits, found.limits_intervals, strict=True):
            self.add_band(plot, *interval, tokens.warning)
            self.add_level(plot, limit, tokens.warning, is_dashed=True)
        self.add_level(plot, found.bias, tokens.accent, is_dashed=False)
        self.add_points(plot, found.means, found.differences)
        shown = [*found.differences, *found.limits_intervals[0], *found.limits_intervals[1]]
        plot.setYRange(*spread(shown, definition.unit), padding=PADDING)
        plot.setXRange(*spread(found.means, definition.unit), padding=PADDING)
        plot.getAxis("bottom").setTicks(None)
        unit = _(definition.unit)
        self.name_axes(
            plot,
            _("Mean of the two [{unit}]").format(unit=unit),
            _("First minus second [{unit}]").format(unit=unit),
        )


def agreement_text(found: Agreement | None) -> str:
    """Say what the plot shows."""
    if found is None:
        return ""
    return _(
        "{n} patients. Bias {bias} ({bias_low} to {bias_high}), limits of agreement {low} and "
        "{high}: between them lie 95 % of differences."
    ).format(
        n=len(found.means),
        bias=number(found.bias, 2),
        bias_low=number(found.bias_interval[0], 2),
        bias_high=number(found.bias_interval[1], 2),
        low=number(found.limits[0], 2),
        high=number(found.limits[1], 2),
    )
