"""A sensor that is pulled out and put back a hundred times, with the real OpenNI2 library.

Needs what its tests need: ``libopenni2-dev`` and a C++ compiler. It takes some four minutes, and
is not resumed.
"""

import importlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.long_run import Run
from benchmarks.table import Row

WHOLE, QUICK = 100, 3
SETTLED = 5
"""Pulls after which libraries have all that they load."""


def rows(run: Run) -> Iterable[Row]:
    """Pull and put back."""
    told = list(pulls(run.n_to_do(WHOLE, 0, QUICK), run))
    after = f"after {len(told)} of {WHOLE} pulls while recording"
    back_s = [one["seconds"] for one in told]
    is_told = [bool(one["sentence"] and one["burst"]) for one in told]
    yield Row(f"sensor back {after}", len(told), "times", len(told), "goal")
    yield Row("told in a sentence, for the view and for the recording", sum(is_told), "times",
              len(told), "goal")  # fmt: skip
    yield Row("longest until the picture is back", max(back_s), "s")
    first = told[min(SETTLED, len(told) - 1)]
    for name, unit in (("memory_mb", "MB"), ("n_files", "files"), ("n_threads", "threads")):
        what = f"{name.partition('_')[0 if name == 'memory_mb' else 2]} more than after {SETTLED}"
        yield Row(what, told[-1][name] - first[name], unit)


def pulls(n_pulls: int, run: Run) -> Iterator[dict[str, Any]]:
    """Give what the trial tells of each pull."""
    virtual: Any = importlib.import_module("tests.virtual_openni2.virtual_sensor")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        library = virtual.build_openni2(folder / "openni2")
        dump = folder / "sensor.bin"
        virtual.write_dump(dump, np.random.default_rng(5))
        found = {"OPENNI2_REDIST": str(library), "ADIBAS_VIRTUAL_SENSOR": str(dump)}
        with subprocess.Popen(  # noqa: S603  (our own module)
            [sys.executable, "-m", "benchmarks.sensor_trial", str(n_pulls)],
            cwd=Path(__file__).parents[1],
            env=os.environ | found,
            stdout=subprocess.PIPE,
        ) as trial:
            if trial.stdout is None:
                raise RuntimeError("the trial says nothing")
            for number, line in enumerate(trial.stdout):
                told: dict[str, Any] = json.loads(line)
                if "left" not in told:
                    yield told
                elif told["left"]:
                    raise RuntimeError(f"threads are left: {told['left']}")
                run.progress(number, n_pulls)
        if trial.returncode:
            raise RuntimeError(f"the trial ended with {trial.returncode}")
