"""What a protocol file says at a line, read with its kind; mistakes are collected, not raised."""

import re

from adibas.data.protocols import Wording
from adibas.data.views import VIEWS
from adibas.errors import ProtocolError
from adibas.measures.json_lines import Node
from adibas.texts import Message, message

LONGEST_ID = 40
LONGEST_TEXT = 2000
MOST_OF_EACH = 2000
_ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.:\-]*")
_LANGUAGE = re.compile(r"[a-z]{2}")

TEXT, NUMBER, LIST, GROUP = (
    message("a text"),
    message("a number"),
    message("a list"),
    message("a group of values"),
)


class Findings:
    """The mistakes of one file, each with its line."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.errors: list[ProtocolError] = []

    def mistake(self, node: Node, message_id: str, **fields: object) -> None:
        """Keep a mistake; its sentence begins with ``{file}, line {line}:``."""
        self.errors.append(ProtocolError(message_id, file=self.file, line=node.line, **fields))

    def is_kind(self, node: Node, kind: Message) -> None:
        """Tell that a value is of the wrong kind."""
        self.mistake(node, "{file}, line {line}: here must stand {kind}. Correct it.", kind=kind)


class Group:
    """The named values of one pair of braces."""

    def __init__(self, node: Node, findings: Findings) -> None:
        self.node = node
        self.findings = findings
        self._members = node.value if isinstance(node.value, dict) else {}
        if not isinstance(node.value, dict):
            findings.is_kind(node, GROUP)

    def allow_only(self, *names: str) -> None:
        """Tell of names that a protocol does not know: they would do nothing."""
        for name, node in self._members.items():
            if name not in names:
                self.findings.mistake(
                    node,
                    "{file}, line {line}: {name} is not known here. Known are: {names}. Correct or "
                    "remove it.",
                    name=name[:LONGEST_ID],
                    names=", ".join(names),
                )

    def get(self, name: str) -> Node | None:
        """Return a value, None where it is left out or null."""
        node = self._members.get(name)
        return None if node is None or node.value is None else node

    def need(self, name: str) -> Node | None:
        """Return a value; a mistake is kept where it is left out."""
        node = self.get(name)
        if node is None and isinstance(self.node.value, dict):
            self.findings.mistake(
                self.node, "{file}, line {line}: {name} is missing. Add it.", name=name
            )
        return node

    def text(self, name: str, *, is_needed: bool = True) -> str:
        """Return a text, empty where it is missing or wrong."""
        node = self.need(name) if is_needed else self.get(name)
        return "" if node is None else text_of(node, self.findings)

    def number(self, name: str, *, is_needed: bool = True) -> float | None:
        """Return a number, None where it is missing or wrong."""
        node = self.need(name) if is_needed else self.get(name)
        return None if node is None else number_of(node, self.findings)

    def identifier(self, name: str) -> str:
        """Return a name for programs, empty where it is missing or wrong."""
        node = self.need(name)
        if node is None:
            return ""
        found = text_of(node, self.findings)
        if found and (not _ID.fullmatch(found) or len(found) > LONGEST_ID):
            self.findings.mistake(
                node,
                "{file}, line {line}: {name} is no name for a program. Use up to {most} letters "
                "without accents, digits and . _ - : only.",
                name=found[:LONGEST_ID],
                most=LONGEST_ID,
            )
            return ""
        return found

    def wording(self, name: str, *, is_needed: bool = True) -> Wording | None:
        """Return a text that may stand in several languages."""
        node = self.need(name) if is_needed else self.get(name)
        if node is None:
            return None
        if not isinstance(node.value, dict):
            found = text_of(node, self.findings)
            return Wording({"en": found}) if found else None
        texts = {}
        for language, part in node.value.items():
            if not _LANGUAGE.fullmatch(language):
                self.findings.mistake(
                    part,
                    "{file}, line {line}: {name} is no language. Give its two letters, such as en.",
                    name=language[:LONGEST_ID],
                )
            words = text_of(part, self.findings)
            if words:
                texts[language] = words
        return Wording(texts) if texts else None

    def items(self, name: str, *, is_needed: bool = True) -> tuple[Node, ...]:
        """Return the members of a list."""
        node = self.need(name) if is_needed else self.get(name)
        if node is None:
            return ()
        if not isinstance(node.value, list):
            self.findings.is_kind(node, LIST)
            return ()
        return tuple(node.value)

    def texts(self, name: str, *, is_needed: bool = True) -> tuple[str, ...]:
        """Return the members of a list of texts, without those that are none."""
        found = (text_of(node, self.findings) for node in self.items(name, is_needed=is_needed))
        return tuple(text for text in found if text)

    def groups(self, name: str, *, is_needed: bool = True) -> tuple["Group", ...]:
        """Return the members of a list of groups."""
        nodes = self.items(name, is_needed=is_needed)
        if len(nodes) > MOST_OF_EACH:
            self.findings.mistake(
                nodes[0],
                "{file}, line {line}: more than {most} of {name} are no protocol. Divide it.",
                most=MOST_OF_EACH,
                name=name,
            )
            return ()
        groups = [Group(node, self.findings) for node in nodes]
        return tuple(group for group in groups if isinstance(group.node.value, dict))

    def truth(self, name: str) -> bool:
        """Return whether something is asked for; not where it is left out."""
        node = self.get(name)
        if node is not None and not isinstance(node.value, bool):
            self.findings.mistake(
                node,
                "{file}, line {line}: {name} is either true or false. Correct it.",
                name=name,
            )
        return node is not None and node.value is True

    def views(self) -> tuple[str, ...]:
        """Return the views, of which one at least is needed."""
        found = []
        nodes = self.items("views")
        if not nodes and self.get("views") is not None:
            self.findings.mistake(
                self.node,
                "{file}, line {line}: no view is named. Give one of: {names}.",
                names=", ".join(VIEWS),
            )
        for node in nodes:
            view = text_of(node, self.findings)
            if view in VIEWS:
                found.append(view)
            elif view:
                self.findings.mistake(
                    node,
                    "{file}, line {line}: the view {name} is not known. Give one of: {names}.",
                    name=view[:LONGEST_ID],
                    names=", ".join(VIEWS),
                )
        return tuple(dict.fromkeys(found))


def text_of(node: Node, findings: Findings) -> str:
    """Return a text that is not empty; else keep a mistake."""
    if not isinstance(node.value, str) or not node.value.strip():
        findings.is_kind(node, TEXT)
        return ""
    if len(node.value) > LONGEST_TEXT:
        findings.mistake(
            node,
            "{file}, line {line}: this text is longer than {most} characters. Shorten it.",
            most=LONGEST_TEXT,
        )
        return ""
    return node.value


def number_of(node: Node, findings: Findings) -> float | None:
    """Return a number; else keep a mistake."""
    if isinstance(node.value, bool) or not isinstance(node.value, float):
        findings.is_kind(node, NUMBER)
        return None
    return node.value
