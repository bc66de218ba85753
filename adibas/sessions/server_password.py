"""The password of the database's server: in the desktop's keyring, or asked each time."""

from contextlib import suppress

import keyring
from keyring.errors import KeyringError

from adibas.sessions.server_address import ServerAddress

SERVICE = "ADiBAS database server"


def kept_password(address: ServerAddress) -> str | None:
    """Return the password that the keyring has; None where there is none, or no keyring."""
    try:
        return keyring.get_password(SERVICE, str(address))
    except KeyringError:
        return None


def keep_password(address: ServerAddress, password: str) -> None:
    """Keep a password that the server took; without a keyring it is asked again next time."""
    with suppress(KeyringError):
        keyring.set_password(SERVICE, str(address), password)
