"""What a command says, and where: results on stdout, everything else on stderr."""

import json
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress

from tqdm import tqdm

from adibas.progress import Progress

SECONDS_BEFORE_A_BAR = 1.0


class Console:
    """The terminal, or with `--json` one document on stdout.

    Parameters
    ----------
    is_json : bool
        With True nothing but the document goes to stdout, and no bar is drawn.
    """

    def __init__(self, *, is_json: bool) -> None:
        self._is_json = is_json

    def say(self, text: str) -> None:
        """Print a sentence for a reader; on stderr where stdout carries JSON."""
        if self._is_json:
            self.warn(text)
        else:
            print(text)  # noqa: T201

    def tell(self, secret: str) -> None:
        """Print what only the result may carry: nothing where the result is JSON."""
        if not self._is_json:
            print(secret)  # noqa: T201

    def warn(self, text: str) -> None:
        """Print a sentence on stderr."""
        if sys.stderr is not None:  # closed: print would take stdout
            with suppress(OSError):  # nobody reads it, and there is nowhere else to say so
                print(text, file=sys.stderr)  # noqa: T201

    def flush(self) -> None:
        """See that everything said has arrived.

        Raises
        ------
        OSError
            Stdout takes nothing any more.
        """
        if sys.stdout is not None:
            sys.stdout.flush()

    def give(self, document: Mapping[str, object]) -> None:
        """Print the result as JSON where it was asked for."""
        if self._is_json:
            print(json.dumps(document, allow_nan=False))  # noqa: T201

    @contextmanager
    def progress(self, label: str) -> Iterator[Progress]:
        """Give a function that draws a bar on work over one second."""
        is_hidden = self._is_json or sys.stderr is None or not sys.stderr.isatty()
        with tqdm(
            desc=label, delay=SECONDS_BEFORE_A_BAR, disable=is_hidden, file=sys.stderr, leave=False
        ) as bar:

            def advance(done: int, total: int) -> None:
                bar.total = total or None
                bar.update(done - bar.n)

            yield advance
