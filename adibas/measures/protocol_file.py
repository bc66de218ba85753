"""Protocol files: read with every mistake told by its line, and nothing taken that is in doubt.

The format is described in docs/protocols.md.
"""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from adibas.data.protocols import Protocol
from adibas.errors import ProtocolError
from adibas.measures.json_lines import LARGEST_FILE, parse_lines
from adibas.measures.protocol_fields import Findings, Group
from adibas.measures.protocol_places import Places
from adibas.measures.protocol_rules import Rules

FORMAT = "adibas-protocol"
VERSION = 1
MOST_KEPT = 64


@dataclass(frozen=True, slots=True)
class CheckedProtocol:
    """A protocol file as read; `protocol` is None where `errors` has any."""

    protocol: Protocol | None
    errors: tuple[ProtocolError, ...]


def load_protocol(path: Path) -> Protocol:
    """Return the protocol in a file.

    Raises
    ------
    ProtocolError
        The first mistake of the file, with its line.
    """
    try:
        changed_ns = path.stat().st_mtime_ns
    except OSError:
        changed_ns = 0  # whoever reads it says why it cannot be read
    return _loaded(path.absolute(), changed_ns)


@lru_cache(maxsize=MOST_KEPT)
def _loaded(path: Path, _changed_ns: int) -> Protocol:
    """Read each state of a file once: the one of 1,470 measures takes a while."""
    checked = check_protocol(path)
    if checked.protocol is None:
        raise checked.errors[0]
    return checked.protocol


def check_protocol(path: Path) -> CheckedProtocol:
    """Return the protocol in a file, or all of its mistakes in the order of their lines."""
    try:
        with path.open("rb") as file:
            encoded = file.read(4 * LARGEST_FILE + 1)
        text = encoded.decode("utf-8-sig")
    except OSError as error:
        reason = error.strerror or str(error)
        unread = ProtocolError(
            "{file} cannot be read: {reason}. Check the name, and that the disk is there.",
            file=path.name,
            reason=reason,
        )
        return CheckedProtocol(None, (unread,))
    except UnicodeDecodeError as error:
        line = encoded.count(b"\n", 0, error.start) + 1
        no_text = ProtocolError(
            "{file}, line {line}: this is no text in UTF-8. Save the file as UTF-8.",
            file=path.name,
            line=line,
        )
        return CheckedProtocol(None, (no_text,))
    return read_protocol(text, path.name)


def read_protocol(text: str, file: str) -> CheckedProtocol:
    """Return the protocol in `text`, the content of the file named `file`, or its mistakes."""
    findings = Findings(file)
    try:
        document = parse_lines(text, file)
    except ProtocolError as error:
        return CheckedProtocol(None, (error,))
    protocol = _assembled(Group(document, findings))
    errors = sorted(findings.errors, key=lambda error: int(str(error.fields["line"])))
    return CheckedProtocol(None if errors else protocol, tuple(errors))


def _assembled(whole: Group) -> Protocol | None:
    """Return the protocol; None where something is missing, which the findings tell."""
    whole.allow_only(
        *("format", "version", "id", "title", "source", "revision", "notes"),
        *("landmarks", "derived", "measures", "every_pair", "every_triplet"),
    )
    _check_format(whole)
    protocol_id, title = whole.identifier("id"), whole.wording("title")
    source, revision = whole.text("source"), whole.text("revision")
    notes = whole.wording("notes", is_needed=False)
    places = Places(whole)
    rules = Rules(whole, places)
    measures = (*rules.measures(), *rules.every())
    if not measures and not whole.findings.errors:
        whole.findings.mistake(
            whole.node, "{file}, line {line}: nothing is measured. Add measures."
        )
    if title is None or whole.findings.errors:
        return None
    return Protocol(
        *(protocol_id, title, source, revision), places.landmarks, places.derived, measures, notes
    )


def _check_format(whole: Group) -> None:
    if whole.text("format") not in ("", FORMAT):
        whole.findings.mistake(
            whole.node,
            "{file}, line {line}: this is no protocol of ADiBAS. Its format must be {name}.",
            name=FORMAT,
        )
    if whole.number("version") not in (None, VERSION):
        whole.findings.mistake(
            whole.node,
            "{file}, line {line}: this protocol was made for a later version of ADiBAS. Update "
            "the program.",
        )
