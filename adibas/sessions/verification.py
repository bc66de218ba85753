"""Whether the store is whole: database, audit log, files; and what to do where it is not."""

from collections.abc import Iterator
from dataclasses import dataclass

from sqlalchemy import select

from adibas.errors import StoreError
from adibas.progress import Progress
from adibas.sessions.audit import BEGINNING, THE_HEAD, AuditLine, AuditLog, hash_of
from adibas.sessions.database import DATABASE_FILE, Database
from adibas.sessions.rows import Row, Transaction, row_of
from adibas.sessions.schema import AUDIT, AUDIT_HEAD, FILES, LEFTOVERS, RECORDINGS
from adibas.sessions.sealed_files import SealedFiles
from adibas.sessions.sealed_folder import SealedFolder
from adibas.sessions.stored_recordings import Recordings
from adibas.texts import describe
from adibas.texts import translate as _


@dataclass(frozen=True, slots=True)
class Finding:
    """Something that is not as it should be.

    Attributes
    ----------
    kind : str
        ``database``, ``audit``, ``missing``, ``changed``, ``orphan`` or ``unfinished``.
    subject : str
        A line's number, or the id of a file.
    text : str
        What it is and what to do, in the user's language.
    """

    kind: str
    subject: str
    text: str


@dataclass(frozen=True, slots=True)
class VerifyReport:
    """What was checked and found.

    Attributes
    ----------
    n_lines, n_files, n_recordings : int
        Lines of the audit log, pictures and surfaces, recordings.
    """

    n_lines: int
    n_files: int
    n_recordings: int
    findings: tuple[Finding, ...]

    @property
    def is_sound(self) -> bool:
        """Whether nothing was found."""
        return not self.findings


class Verification:
    """Looks at everything; changes nothing."""

    def __init__(
        self, database: Database, audit: AuditLog, pictures: SealedFiles, recordings: Recordings
    ) -> None:
        self._database = database
        self._audit = audit
        self._pictures = pictures
        self._recordings = recordings

    def run(self, progress: Progress | None = None) -> VerifyReport:
        """Check everything."""
        on_disk = (self._pictures.ids(), self._recordings.sealed.ids())
        unfinished = self._recordings.sealed.unfinished()
        with self._database.reading() as transaction:
            findings = [*self._database_findings(transaction), *_audit_findings(transaction)]
            n_lines = len(transaction.scalars(select(AUDIT.c.sequence)).all())
            files = _checksums(transaction)
            recordings = list(transaction.execute(select(RECORDINGS)))
            leaving = set(transaction.scalars(select(LEFTOVERS.c.file_id)))
        closed = {r.recording_id: r.sha256 for r in recordings if r.is_closed}
        known = {r.recording_id for r in recordings} | leaving
        kept = {file_id: sha256 for file_id, sha256 in files.items() if sha256 is not None}
        checks = [(self._pictures, *item) for item in kept.items()]
        places: list[tuple[SealedFolder, str, str]] = [
            *checks,
            *((self._recordings.sealed, *item) for item in closed.items()),
        ]
        for done, (folder, file_id, sha256) in enumerate(places, 1):
            findings += _file_findings(folder, file_id, sha256)
            if progress is not None:
                progress(done, len(places))
        findings += _orphans(self._pictures, on_disk[0] - set(files) - leaving)
        findings += _orphans(self._recordings.sealed, (on_disk[1] | unfinished) - known)
        findings += self._unfinished(recordings)
        return VerifyReport(n_lines, len(kept), len(closed), tuple(findings))

    def _database_findings(self, transaction: Transaction) -> Iterator[Finding]:
        if not self._database.is_sound(transaction):
            yield Finding(
                "database",
                DATABASE_FILE,
                _(
                    "The database is damaged. Close the program, keep a copy of the store's "
                    "folder, and restore the folder from a backup."
                ),
            )

    def _unfinished(self, recordings: list[Row]) -> Iterator[Finding]:
        """Give recordings that nobody makes and that recovery could not read."""
        if self._database.is_read_only or self._database.is_shared:
            return  # another opener may be making them
        for record in recordings:
            if not record.is_closed and record.recording_id not in self._recordings.in_the_making:
                yield Finding(
                    "unfinished",
                    record.recording_id,
                    _(
                        "The recording {id} was cut off and cannot be recovered. Restore its file "
                        "from a backup and open the store again, or purge its session."
                    ).format(id=record.recording_id),
                )


def _audit_findings(transaction: Transaction) -> Iterator[Finding]:
    """Follow the chain to its head."""
    previous, expected = BEGINNING, 1
    in_order = select(AUDIT).order_by(AUDIT.c.sequence)
    for line in (AuditLine(*row) for row in transaction.execute(in_order)):
        if line.sequence != expected:
            yield _chain_broken(expected, _("Line {number} of the audit log is missing."))
        elif line.previous_hash != previous or line.hash != hash_of(line):
            yield _chain_broken(line.sequence, _("Line {number} of the audit log was changed."))
        previous, expected = line.hash, line.sequence + 1
    head = row_of(transaction, AUDIT_HEAD, THE_HEAD)
    if head is None or (head.sequence, head.hash) != (expected - 1, previous):
        yield _chain_broken(
            expected, _("The end of the audit log, from line {number}, is missing.")
        )


def _chain_broken(number: int, text: str) -> Finding:
    remedy = _(
        "Somebody changed the database by other means than this program, or the disk is failing. "
        "Keep a copy of the store's folder and compare it with a backup."
    )
    return Finding("audit", str(number), f"{text.format(number=number)} {remedy}")


def _checksums(transaction: Transaction) -> dict[str, str | None]:
    return {row.file_id: row.sha256 for row in transaction.execute(select(FILES))}


def _file_findings(folder: SealedFolder, file_id: str, sha256: str) -> Iterator[Finding]:
    try:
        is_same = folder.sha256(file_id) == sha256
    except StoreError as error:
        yield Finding("missing", file_id, describe(error))
        return
    if not is_same:
        yield Finding(
            "changed",
            file_id,
            _(
                "{folder}/{id} was changed or damaged after it was saved. Restore this file from a "
                "backup."
            ).format(folder=folder.folder.name, id=file_id),
        )


def _orphans(folder: SealedFolder, ids: set[str]) -> Iterator[Finding]:
    for file_id in sorted(ids):
        yield Finding(
            "orphan",
            file_id,
            _(
                "{folder}/{id} belongs to nothing in the database, so nobody can open it. If the "
                "database was restored from an older backup, restore the newer one; otherwise "
                "delete the file."
            ).format(folder=folder.folder.name, id=file_id),
        )
