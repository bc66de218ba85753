"""Where stores are."""

from pathlib import Path

import platformdirs


def default_store_folder() -> Path:
    """Return where this user's store is if none is named."""
    return platformdirs.user_data_path("adibas", appauthor=False) / "store"
