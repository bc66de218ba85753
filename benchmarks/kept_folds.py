"""Evaluations that leave out one group after another, each kept in a file as it is done.

A long run that was interrupted goes on where it was. A file holds what one state of the program
found: after a change of the recognition a new one is begun.
"""

import json
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

import numpy as np

from adibas.gestures.descriptor import DescriptorParams
from adibas.gestures.evaluation import Evaluation, one_left_out, pooled
from adibas.gestures.segments import Examples
from adibas.gestures.training import TrainingParams

COUNTS = ("confusion", "missed", "hits", "n_reported", "n_done")


def kept_leave_one_out(
    called: str,
    n_groups: int,
    examples_of_all: Callable[[], Examples],
    descriptor: DescriptorParams,
    params: TrainingParams,
    file: Path | None,
) -> Evaluation:
    """Return what `leave_one_out` does, of groups 0 to `n_groups` - 1.

    Parameters
    ----------
    called : str
        Tells this data from other data in the same file.
    n_groups : int
    examples_of_all : callable
        Asked only where something is still to be done.
    descriptor, params : as `leave_one_out` takes them
    file : Path or None
        Nothing is kept without one.
    """
    done = {} if file is None else _read(file)
    keys = [f"{called}, {params}, without group {group}" for group in range(n_groups)]
    for group, key in enumerate(keys):
        if key in done:
            continue
        done[key] = one_left_out(examples_of_all(), group, descriptor, params)
        if file is not None:
            with file.open("a", encoding="utf-8") as lines:
                lines.write(json.dumps({"key": key, **_document(done[key])}) + "\n")
    return pooled([done[key] for key in keys])


def _document(found: Evaluation) -> dict[str, object]:
    values = {one.name: getattr(found, one.name) for one in fields(Evaluation)}
    return {
        name: value.tolist() if isinstance(value, np.ndarray) else value
        for name, value in values.items()
    }


def _read(file: Path) -> dict[str, Evaluation]:
    if not file.exists():
        return {}
    rows = [json.loads(line) for line in file.read_text("utf-8").splitlines() if line]
    return {row.pop("key"): _evaluation(row) for row in rows}


def _evaluation(row: dict[str, object]) -> Evaluation:
    arrays: dict[str, object] = {name: np.array(row[name], np.int64) for name in COUNTS}
    arrays |= {name: np.array(row[name], float) for name in ("begin_errors", "end_errors")}
    labels = tuple(np.array(row["labels"]).tolist())
    return Evaluation(**(row | arrays | {"labels": labels}))  # type: ignore[arg-type]
