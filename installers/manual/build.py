"""Builds the manual into ``resources/manual``, where the window finds it: ``make manual``.

It is built when a tree is set up, in seconds, and not kept in the repository: what is built from
pages, protocols and pictures would be a second truth, and each change would be there twice. Nor
is it built on the fly: a user's program has no mkdocs. So ``make run``, ``make installer`` and
wheels take what ``make manual`` made, and it is made anew only where a source is newer.
"""

import os
import shutil
import sys
import tempfile
from pathlib import Path

from mkdocs.commands.build import build
from mkdocs.config import load_config

from installers.bundle import ROOT

CONFIG = Path(__file__).with_name("mkdocs.yml")
BUILT = ROOT / "resources" / "manual"


def build_manual(folder: Path) -> Path:
    """Build all pages into a folder, which is replaced as a whole; return it.

    Raises
    ------
    mkdocs.exceptions.Abort
        A link leads nowhere, or anything else that mkdocs would only warn of.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix=".manual-") as name:
        site = Path(name) / "site"
        config = load_config(str(CONFIG), site_dir=str(site))
        config.plugins.on_startup(command="build", dirty=False)
        build(config)
        shutil.rmtree(folder, ignore_errors=True)
        site.rename(folder)
    return folder


if __name__ == "__main__":
    os.environ.setdefault("NO_MKDOCS_2_WARNING", "1")
    sys.stdout.write(f"{build_manual(BUILT).relative_to(ROOT)}\n")
