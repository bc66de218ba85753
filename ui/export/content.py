"""What of a session leaves, as it is chosen and shown; without Qt."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from adibas.data.report import PictureChoice

if TYPE_CHECKING:
    from adibas.exchange.orders import Order

Kind = Literal["fhir", "dicom", "server"]


@dataclass(frozen=True, slots=True)
class ExportChoice:
    """What was chosen so far.

    Attributes
    ----------
    kind : Kind
        What is made, and where it goes.
    with_identity : bool
        Never so before somebody ticks it.
    pictures : PictureChoice or None
        None: as fits whether the person is told.
    language : str
        Two letters.
    server : str
        Name of the server that is sent to; empty where none is set up.
    protocol : str
        Name of the one to measure by; empty: the one that the session names.
    order : Order or None
        That DICOM files answer; a bundle answers none.
    """

    language: str
    kind: Kind = "fhir"
    with_identity: bool = False
    pictures: PictureChoice | None = None
    server: str = ""
    protocol: str = ""
    order: "Order | None" = None

    @property
    def answered(self) -> "Order | None":
        """Return the order that what leaves answers."""
        return None if self.kind == "fhir" else self.order


@dataclass(frozen=True, slots=True)
class Shown:
    """What the dialog shows of a choice: the pictures in use, what leaves, what to mind."""

    choice: ExportChoice
    pictures: PictureChoice
    content: tuple[str, ...]
    warnings: tuple[str, ...]
