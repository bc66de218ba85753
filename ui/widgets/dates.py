"""Days and moments as the window writes them: the month as a word, so that nobody swaps it."""

from datetime import date, datetime

from PySide6.QtCore import QDate, QDateTime, QLocale, QTime


def day_text(day: date | None) -> str:
    """Return a day such as 27 Mar 2014; empty for None."""
    if day is None:
        return ""
    return QLocale().toString(QDate(day.year, day.month, day.day), "d MMM yyyy")


def moment_text(time_utc: datetime | None) -> str:
    """Return a moment in this computer's time such as 27 Mar 2014, 16:05; empty for None."""
    if time_utc is None:
        return ""
    here = time_utc.astimezone()
    moment = QDateTime(QDate(here.year, here.month, here.day), QTime(here.hour, here.minute))
    return QLocale().toString(moment, "d MMM yyyy, HH:mm")
