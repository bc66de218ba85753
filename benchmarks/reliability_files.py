"""Mutated files for every importer: read or refused in a sentence, whatever is in them.

``--amount`` is the number of files of each kind in this run.
"""

import importlib.util
import json
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from adibas.errors import AdibasError, FileError
from benchmarks.fuzz_importers import IMPORTERS, Importer, Trial
from benchmarks.long_run import Kept, Run
from benchmarks.table import Row

WHOLE, QUICK = 100_000, 200
AT_ONCE = 2_000
"""Files given to one process; then its counts are kept."""


def rows(run: Run) -> Iterable[Row]:
    """Give each importer its files, those of the least first."""
    if importlib.util.find_spec("atheris") is None:
        raise FileError(
            "atheris is not installed. Install it with: pip install atheris (Linux, macOS)."
        )
    folder = run.folder / ("files-quick" if run.is_quick else "files")
    state = Kept(folder / "state.json", {})
    n_given = 0
    for importer in sorted(IMPORTERS, key=lambda one: sum(state.get(one.name, {}).values())):
        counts = Counter[str](state.get(importer.name, {}))
        left = run.n_to_do(WHOLE, _n_done(counts), QUICK)
        place = folder / importer.name.replace(" ", "-")
        counts = _without_mended(counts, importer, place)
        while left > 0:
            n_now = min(left, AT_ONCE)
            counts += _given(importer, n_now, place, _n_done(counts))
            state[importer.name] = counts
            state.keep()
            left -= n_now
            n_given += n_now
            run.progress(n_given, 0)
        yield from _told(importer, counts)


def _n_done(counts: Counter[str]) -> int:
    return counts.total()


def _told(importer: Importer, counts: Counter[str]) -> Iterable[Row]:
    yield Row(f"{importer.name}: mutated files", _n_done(counts), "files", WHOLE, "goal")
    faults = {name: n for name, n in counts.items() if name.startswith("fault ")}
    what = f" ({', '.join(name.removeprefix('fault ') for name in faults)})" if faults else ""
    yield Row(
        f"{importer.name}: crashes, hangs and memory{what}",
        sum(faults.values()),
        "files",
        0,
        "goal",
    )


def _given(importer: Importer, n_files: int, place: Path, seed: int) -> Counter[str]:
    """Let a process of its own give the files; return what became of them."""
    place.mkdir(parents=True, exist_ok=True)
    counts_file = place / "counts.json"
    counts_file.unlink(missing_ok=True)
    words = [importer.name, str(n_files), str(place), str(seed + 1)]
    with (place / "log.txt").open("wb") as log:
        ended = subprocess.run(  # noqa: S603  (our own module)
            [sys.executable, "-m", "benchmarks.fuzz_child", *words],
            cwd=Path(__file__).parents[1],
            stdout=log,
            stderr=log,
            check=False,
        )
    counts = Counter[str](json.loads(counts_file.read_text()) if counts_file.exists() else {})
    if ended.returncode and not counts:
        raise RuntimeError(f"the process did not begin: see {place / 'log.txt'}")
    if ended.returncode:
        counts[f"fault exit-{ended.returncode}"] += 1
    return counts


def _without_mended(counts: Counter[str], importer: Importer, place: Path) -> Counter[str]:
    """Return the counts without faults whose kept file is read or refused by now."""
    kept = [*place.glob("*.fault"), *place.glob("libfuzzer-*")]
    trial = Trial(importer) if kept else None
    for path in kept:
        if trial is not None and _is_mended(trial, path.read_bytes()):
            names = [f"fault {path.stem}"] if path.suffix == ".fault" else _of_exits(counts)
            counts["refused"] += sum(counts.pop(name, 0) for name in names)
            path.unlink()
    if trial is not None:
        trial.close()
    return counts


def _of_exits(counts: Counter[str]) -> list[str]:
    return [name for name in counts if name.startswith("fault exit")]


def _is_mended(trial: Trial, data: bytes) -> bool:
    try:
        trial.give(data)
    except AdibasError:
        return True
    except Exception:  # noqa: BLE001  (whatever it is, it is still there)
        return False
    return True
