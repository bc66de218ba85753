"""Adds and removes people of a store until it is killed; says each change that is saved."""

import itertools
import sys
from pathlib import Path

from adibas.sessions import open_store
from adibas.sessions.key_wrapping import Argon2Params
from adibas.sessions.roles import Role

CHEAP = Argon2Params(iterations=1, lanes=1, memory_kib=8)


def main(folder: str, passphrase: str) -> None:
    """Work on the store in `folder` for ever."""
    with open_store(Path(folder), passphrase) as store:
        for number in itertools.count():
            name = f"person {number}"
            store.people.add(name, Role.OPERATOR, f"the words of {number}", CHEAP)
            print("added", number, flush=True)  # noqa: T201
            store.people.remove(name)
            print("removed", number, flush=True)  # noqa: T201


if __name__ == "__main__":
    main(*sys.argv[1:])
