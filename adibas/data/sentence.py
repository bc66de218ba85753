"""One sentence for the reader, kept until it is known in which language."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from adibas.texts import Message, decimal_text, translate


@dataclass(frozen=True, slots=True)
class Sentence:
    """What a check found, and what to do.

    Attributes
    ----------
    message : Message
        English, with ``{field}`` places.
    fields : mapping
        What stands there; messages are translated, too, and numbers shown with as many decimals
        as `decimals` says.
    decimals : int
        Of numbers that are no integers.
    """

    message: Message
    fields: Mapping[str, object] = field(default_factory=dict)
    decimals: int = 1

    @property
    def text(self) -> str:
        """The sentence in the language in use."""
        return translate(self.message).format(
            **{name: self._shown(value) for name, value in self.fields.items()}
        )

    def _shown(self, value: object) -> object:
        if isinstance(value, Message):
            return translate(value)
        return decimal_text(value, self.decimals) if isinstance(value, float) else value
