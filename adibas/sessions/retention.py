"""How long patients are kept, whose time is over, and their removal by the purge."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import date, datetime
from typing import TYPE_CHECKING, Any, Literal

from sqlalchemy import Select, func, select

from adibas.errors import StoreError
from adibas.progress import Progress
from adibas.sessions.audit import AuditLog
from adibas.sessions.database import Database
from adibas.sessions.defaults import ADULT_AGE, CHILD_UNTIL_AGE, RETENTION_YEARS
from adibas.sessions.roles import Permission
from adibas.sessions.rows import Row, Transaction
from adibas.sessions.schema import IDENTITIES, PATIENTS, SESSIONS
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.sessions.purging import Purge

Reason = Literal["adult", "child", "unknown"]


@dataclass(frozen=True, slots=True)
class RetentionRules:
    """How long is long enough; whoever is responsible for the data chooses the numbers.

    The defaults are no legal advice: `docs/backup.md` tells where they come from, and that the law
    in force at the clinic decides.

    Attributes
    ----------
    years : int
        After the last session: 15.
    child_until_age : int
        Who was a child at the last session is kept up to this age at least: 25.
    """

    years: int = RETENTION_YEARS
    child_until_age: int = CHILD_UNTIL_AGE

    def __post_init__(self) -> None:
        if self.years < 1 or self.child_until_age < ADULT_AGE:
            raise ValueError(f"no rules: {self}")


@dataclass(frozen=True, slots=True)
class Expired:
    """A patient whose time is over.

    Attributes
    ----------
    last_utc : datetime
        Of the last session, hidden ones included; without any, when the patient was added.
    reason : str
        By which rule: ``adult``, ``child``, or ``unknown`` where no birth date is known.
    since : date
        When the time was over.
    """

    pseudonym: str
    n_sessions: int
    last_utc: datetime
    reason: Reason
    since: date

    @property
    def text(self) -> str:
        """Say why, in the language in use."""
        reasons = {
            "adult": _("an adult, last seen {last}; the time was over on {since}"),
            "child": _("a child when last seen, {last}; the time was over on {since}"),
            "unknown": _("birth date not known, last seen {last}; the time was over on {since}"),
        }
        return reasons[self.reason].format(last=self.last_utc.date(), since=self.since)


class Retention:
    """Finds and removes patients whose time is over."""

    def __init__(self, database: Database, audit: AuditLog, purge: "Callable[[], Purge]") -> None:
        self._database = database
        self._audit = audit
        self._purge = purge

    def expired(self, rules: RetentionRules, today: date) -> tuple[Expired, ...]:
        """Return whose time is over, longest first; nothing is changed."""
        self._audit.require(Permission.RETAIN)
        with self._database.reading() as transaction:
            over = _over(transaction, _everybody(), rules, today)
        return tuple(sorted(over, key=lambda one: (one.since, one.pseudonym)))

    def apply(
        self, rules: RetentionRules, today: date, progress: Progress | None = None
    ) -> tuple[Expired, ...]:
        """Purge whose time is over, and return who that was; the log has a line for each.

        Who came back before their turn stays, with all that there is of them. What `progress`
        raises ends it before the next one; the log sums up who is gone by then.

        Raises
        ------
        StoreError
            The store is read-only, or a recording of one of them is being made.
        """
        self._audit.require(Permission.RETAIN)
        self._database.check_writable()
        over = self.expired(rules, today)
        purge, gone = self._purge(), []
        try:
            for n_done, one in enumerate(over, 1):
                if purge.patient(one.pseudonym, still=_still_over(one.pseudonym, rules, today)):
                    gone.append(one)
                if progress is not None:
                    progress(n_done, len(over))
        finally:
            if gone:
                self._audit.append(
                    "purge", "store", by="retention", patients=len(gone), years=rules.years
                )
        return tuple(gone)


def _everybody() -> Select[Any]:
    last = func.max(SESSIONS.c.started_utc).label("last_utc")
    return (
        select(
            PATIENTS.c.pseudonym,
            PATIENTS.c.created_utc,
            IDENTITIES.c.birth_date,
            last,
            func.count(SESSIONS.c.session_id).label("n_sessions"),
        )
        .join(IDENTITIES, IDENTITIES.c.pseudonym == PATIENTS.c.pseudonym)
        .outerjoin(SESSIONS, SESSIONS.c.pseudonym == PATIENTS.c.pseudonym)
        .group_by(PATIENTS.c.pseudonym, IDENTITIES.c.birth_date)
    )


def _over(
    transaction: Transaction, whom: Select[Any], rules: RetentionRules, today: date
) -> list[Expired]:
    judged = (_judged(row, rules) for row in transaction.execute(whom))
    return [one for one in judged if one.since <= today]


def _still_over(
    pseudonym: str, rules: RetentionRules, today: date
) -> Callable[[Transaction], bool]:
    whom = _everybody().where(PATIENTS.c.pseudonym == pseudonym)
    return lambda transaction: bool(_over(transaction, whom, rules, today))


def _judged(row: Row, rules: RetentionRules) -> Expired:
    last_utc = datetime.fromisoformat(row.last_utc or row.created_utc)
    over = _years_later(last_utc.date(), rules.years)
    reason: Reason = "adult"
    if row.birth_date is None:
        # It may have been a newborn: too long is put right at any time, too short never.
        reason = "unknown"
        over = max(over, _years_later(last_utc.date(), rules.child_until_age))
    else:
        born = date.fromisoformat(row.birth_date)
        if last_utc.date() < _years_later(born, ADULT_AGE):
            reason = "child"
            over = max(over, _years_later(born, rules.child_until_age))
    return Expired(row.pseudonym, row.n_sessions, last_utc, reason, over)


def _years_later(day: date, years: int) -> date:
    try:
        return day.replace(year=day.year + years)
    except ValueError:  # the 29th of February
        try:
            return day.replace(year=day.year + years, day=28)
        except ValueError as error:
            raise StoreError("That many years are no date any more. Give fewer.") from error
