"""How far observers agree, from their files: every figure of one session, and correlations."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from adibas.arrays import FloatArray
from adibas.behaviour.agreement import (
    AgreementParams,
    AgreementResult,
    Figure,
    agreement,
    interval_values,
)
from adibas.behaviour.chance import Coefficient
from adibas.data.coding import Coding
from adibas.data.ethogram import Ethogram
from adibas.data.sentence import Sentence
from adibas.errors import BehaviourError
from adibas.measures.reliability import icc_2_1
from adibas.recordings.codings import read_codings
from adibas.texts import message

LEAST_INTERVALS = 5
FEW_INTERVALS = message(
    "A correlation takes {least} intervals at least, and there are {n}. Choose shorter intervals."
)
NO_SPREAD = message(
    "All intervals have the same value, so that a correlation has no meaning. Look at the share of "
    "agreement."
)
SESSIONS_ALONE = message("These sessions are not in every file, and are left out: {names}.")


@dataclass(frozen=True, slots=True, eq=False)
class ComparedSession:
    """One session of several observers, and how far they agree."""

    name: str
    codings: tuple[Coding, ...]
    result: AgreementResult


@dataclass(frozen=True, slots=True, eq=False)
class AgreementReport:
    """All sessions that every file has.

    Attributes
    ----------
    files : tuple of str
        Their names; the observers stand in their order, those of one file side by side.
    params : AgreementParams
    sessions : tuple of ComparedSession
    notices : tuple of Sentence
    """

    files: tuple[str, ...]
    params: AgreementParams
    sessions: tuple[ComparedSession, ...]
    notices: tuple[Sentence, ...]


def compare_files(
    paths: Sequence[Path], ethogram: Ethogram | None, params: AgreementParams
) -> AgreementReport:
    """Compare the codings of several files; sessions are paired by their names.

    Where every file holds one session, they are paired whatever their names. A file may hold
    several observers of a session, as our own tables may: all of them are compared.

    Raises
    ------
    BehaviourError
        A file cannot be used, or no session is in all of them.
    """
    named = [_by_session(read_codings(path, ethogram)) for path in paths]
    if all(len(some) == 1 for some in named):
        together = tuple(one for some in named for codings in some.values() for one in codings)
        return _report(paths, params, {together[0].name: together}, ())
    shared = [name for name in named[0] if all(name in some for some in named)]
    if not shared:
        raise BehaviourError(
            "No session is in all files. Give the sessions the same names: those of the recording."
        )
    alone = sorted({name for some in named for name in some} - set(shared))
    notices = (Sentence(SESSIONS_ALONE, {"names": ", ".join(alone)}),) if alone else ()
    groups = {name: tuple(one for some in named for one in some[name]) for name in shared}
    return _report(paths, params, groups, notices)


def compare_codings(codings: Sequence[Coding], params: AgreementParams) -> AgreementReport:
    """Compare codings of one session that are at hand.

    Raises
    ------
    BehaviourError
        Fewer than two, or they cannot be compared.
    """
    groups = {codings[0].name: tuple(codings)}
    return AgreementReport(
        tuple(one.observer for one in codings), params, _compared(groups, params), ()
    )


def _by_session(codings: Sequence[Coding]) -> dict[str, list[Coding]]:
    groups: dict[str, list[Coding]] = {}
    for one in codings:
        groups.setdefault(one.name, []).append(one)
    return groups


def _report(
    paths: Sequence[Path],
    params: AgreementParams,
    groups: dict[str, tuple[Coding, ...]],
    notices: tuple[Sentence, ...],
) -> AgreementReport:
    names = tuple(path.name for path in paths)
    return AgreementReport(names, params, _compared(groups, params), notices)


def _compared(
    groups: dict[str, tuple[Coding, ...]], params: AgreementParams
) -> tuple[ComparedSession, ...]:
    return tuple(
        ComparedSession(name, codings, _with_correlations(codings, params))
        for name, codings in groups.items()
    )


def _with_correlations(codings: Sequence[Coding], params: AgreementParams) -> AgreementResult:
    found = agreement(codings, params)
    return AgreementResult(
        found.observers,
        found.within_ms,
        (*found.figures, *_correlations(codings, params)),
        found.tables,
        found.matches,
        found.differences,
        found.notices,
    )


def _correlations(codings: Sequence[Coding], params: AgreementParams) -> Iterator[Figure]:
    """Yield the absolute agreement of counts, and of durations of states, over intervals."""
    behaviours = {one.name: one.kind for coding in codings for one in coding.ethogram.behaviours}
    subjects = {one.subject for coding in codings for one in coding.occurrences}
    for subject in sorted(subjects):
        for name, kind in behaviours.items():
            counts, seconds = interval_values(codings, name, subject, params.interval_ms)
            yield Figure(subject, name, icc_of("icc-count", counts))
            if kind == "state":
                yield Figure(subject, name, icc_of("icc-duration", seconds))


def icc_of(method: str, table: FloatArray) -> Coefficient:
    """Return ICC(2,1), absolute agreement of single observers.

    Parameters
    ----------
    method : str
        What the coefficient is called.
    table : (n, k) array
        A row an interval, a column an observer.
    """
    n = len(table)
    if n < LEAST_INTERVALS:
        told = {"least": LEAST_INTERVALS, "n": n}
        return Coefficient(method, None, n, reason=Sentence(FEW_INTERVALS, told))
    if np.ptp(table) == 0:
        return Coefficient(method, None, n, reason=Sentence(NO_SPREAD))
    return Coefficient(method, icc_2_1(table).value, n)
