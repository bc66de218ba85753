"""The comparison screen: two sessions, a protocol, and six pages. No decisions."""

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QFileDialog,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from adibas.texts import translate as _
from ui.comparison.back_content import Backs
from ui.comparison.back_page import BackPage
from ui.comparison.body_content import Bodies
from ui.comparison.body_page import BodyPage
from ui.comparison.choosers import Choosers
from ui.comparison.content import Choices, Differences, Pair, Repeats, Trends
from ui.comparison.differences_page import DifferencesPage
from ui.comparison.pictures_page import PicturesPage
from ui.comparison.presenter import ComparisonPresenter
from ui.comparison.repeats_page import RepeatsPage
from ui.comparison.trends_page import TrendsPage
from ui.navigation import TITLES
from ui.theme import Theme
from ui.widgets.dates import moment_text
from ui.widgets.rows import Key
from ui.widgets.screen import Screen


class ComparisonScreen(Screen):
    """What is compared above, and below it the pages that show it."""

    name = "comparison"

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._choosers = Choosers(self)
        self._lack, self._go = QLabel(self), QPushButton(self)
        self._nothing = ("", "")
        self._is_bound = False
        self._pages = QTabWidget(self)
        self._pictures, self._differences = PicturesPage(self), DifferencesPage(self)
        self._trends, self._repeats = TrendsPage(theme, self), RepeatsPage(theme, self)
        self._back, self._body = BackPage(theme, self), BodyPage(self)
        for page in self._all_pages():
            self._pages.addTab(page, "")
        self._lack.setWordWrap(True)
        self._lack.setProperty("kind", "warning")
        lacking = QHBoxLayout()
        lacking.addWidget(self._lack, 1)
        lacking.addWidget(self._go)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self._choosers)
        column.addLayout(lacking)
        column.addWidget(self._pages, 1)
        self.retranslate()

    def bind(self, presenter: ComparisonPresenter) -> None:
        """Send what the user does to `presenter`, and own it."""
        self._presenter = presenter
        self._is_bound = True
        self._choosers.sessions_chosen.connect(presenter.choose_sessions)
        self._choosers.protocol_chosen.connect(presenter.choose_protocol)
        self._go.clicked.connect(lambda: presenter.go_to(self._nothing[1]))
        self._pictures.view_chosen.connect(presenter.pictures.choose_view)
        self._back.seen.connect(presenter.back.look)
        self._back.report_asked.connect(lambda: self._ask_report(_("Report on the back"), "back"))
        self._body.report_asked.connect(lambda: self._ask_report(_("Report on the body"), "body"))
        self._body.seen.connect(presenter.body.look)
        self._differences.trend_asked.connect(self._show_trend)
        self._repeats.operator_chosen.connect(presenter.choose_operator)
        for page in (self._trends, self._repeats):
            page.picture_asked.connect(lambda page=page: self._ask_file(page))

    def retranslate(self) -> None:
        """Set the texts in the language in use."""
        self._choosers.retranslate()
        for page in self._all_pages():
            page.retranslate()
        titles = (
            *(_("P&ictures"), _("&Differences"), _("&Trends"), _("&Repeats")),
            *(_("The bac&k"), _("The bod&y")),
        )
        for index, title in enumerate(titles):
            self._pages.setTabText(index, title)
        self._word_lack()
        if self._is_bound:
            self._presenter.refresh()

    def entered(self) -> None:
        self._presenter.enter()

    def left(self) -> None:
        self._presenter.leave()

    def closed(self) -> None:
        self._presenter.close()

    def show_nothing(self, sentence: str, screen: str) -> None:
        self._nothing = (sentence, screen)
        self._word_lack()

    def show_choices(self, choices: Choices) -> None:
        self._choosers.show_choices(choices)
        self._choosers.setVisible(bool(choices.sessions))
        self._repeats.show_operators(choices.operators, choices.operator)
        earlier, later = (
            "" if one is None else moment_text(one.started_utc)
            for one in (choices.earlier, choices.later)
        )
        for page in (self._pictures, self._back, self._body):
            page.show_dates(earlier, later)

    def show_pair(self, views: tuple[str, ...], pair: Pair | None) -> None:
        self._pictures.show_pair(views, pair)

    def show_backs(self, backs: Backs) -> None:
        self._back.show_backs(backs)

    def show_bodies(self, bodies: Bodies) -> None:
        self._body.show_bodies(bodies)

    def show_differences(self, differences: Differences) -> None:
        self._differences.show_differences(differences)

    def show_trends(self, trends: Trends) -> None:
        self._trends.show_trends(trends)

    def show_repeats(self, repeats: Repeats) -> None:
        self._repeats.show_repeats(repeats)

    def _all_pages(
        self,
    ) -> tuple[PicturesPage, DifferencesPage, TrendsPage, RepeatsPage, BackPage, BodyPage]:
        numbers = self._differences, self._trends, self._repeats
        return self._pictures, *numbers, self._back, self._body

    def _word_lack(self) -> None:
        sentence, screen = self._nothing
        for part in (self._lack, self._go):
            part.setVisible(bool(sentence))
        if sentence:
            self._lack.setText(_(sentence))
            self._go.setText(_("Go to {screen}").format(screen=_(TITLES[screen])))

    def _show_trend(self, key: Key) -> None:
        self._pages.setCurrentWidget(self._trends)
        self._trends.choose(key)

    def _ask_report(self, title: str, name: str) -> None:
        """Ask where the report on body and back goes."""
        kinds = "PDF (*.pdf);;Excel (*.xlsx)"
        dialog = self._file_dialog(title, kinds, f"{name}.pdf")
        dialog.fileSelected.connect(lambda path: self._presenter.save_report(Path(path)))
        dialog.open()

    def _ask_file(self, page: TrendsPage | RepeatsPage) -> None:
        """Draw the plot as it is seen now, and ask where it goes."""
        picture = page.picture()
        if picture is None:
            return
        name, png = picture
        dialog = self._file_dialog(_("Picture of the plot"), "PNG (*.png)", f"{name}.png")
        dialog.fileSelected.connect(lambda path: self._presenter.save_picture(Path(path), png))
        dialog.open()

    def _file_dialog(self, title: str, kinds: str, name: str) -> QFileDialog:
        """Return a dialog that asks where a file goes; `name` is what it suggests."""
        dialog = QFileDialog(self, title, "", kinds)
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setDefaultSuffix(Path(name).suffix.removeprefix("."))
        dialog.filterSelected.connect(lambda kind: dialog.setDefaultSuffix(_ending_of(kind)))
        dialog.selectFile(name)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        return dialog


def _ending_of(kind: str) -> str:
    """Return the ending in a filter such as ``PDF (*.pdf)``."""
    return kind.rpartition(".")[2].removesuffix(")")
