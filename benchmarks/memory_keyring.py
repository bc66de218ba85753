"""A keyring that forgets: benchmarks open stores without a question and without a desktop."""

import json

import keyring
from keyring.backend import KeyringBackend


class MemoryKeyring(KeyringBackend):
    """Keeps passwords for as long as the process runs."""

    priority = 1.0

    def __init__(self, kept: dict[str, str]) -> None:
        super().__init__()  # type: ignore[no-untyped-call]
        self.kept = kept

    def get_password(self, service: str, username: str) -> str | None:
        """Return what was set, None if nothing was."""
        return self.kept.get(f"{service}/{username}")

    def set_password(self, service: str, username: str, password: str) -> None:
        """Keep a password."""
        self.kept[f"{service}/{username}"] = password

    def delete_password(self, service: str, username: str) -> None:
        """Forget a password."""
        self.kept.pop(f"{service}/{username}", None)


def use_memory_keyring(content: str = "") -> MemoryKeyring:
    """Make it the keyring of this process; `content` is what another one's `dumped` returned."""
    ring = MemoryKeyring(json.loads(content) if content else {})
    keyring.set_keyring(ring)
    return ring


def dumped(ring: MemoryKeyring) -> str:
    """Return the content as a text for another process."""
    return json.dumps(ring.kept)
