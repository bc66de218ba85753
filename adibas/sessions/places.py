"""Where stores are."""

from pathlib import Path

import platformdirs

ID_LENGTH = 32
"""Of a recording, with which the names of its codings begin."""
PICTURES_FOLDER, RECORDINGS_FOLDER, CODINGS_FOLDER = "pictures", "recordings", "codings"
IN_THE_MAKING = ".restoring-"
"""Begins the name of the folder that a backup is restored in before it gets its own."""


def default_store_folder() -> Path:
    """Return where this user's store is if none is named."""
    return platformdirs.user_data_path("adibas", appauthor=False) / "store"
