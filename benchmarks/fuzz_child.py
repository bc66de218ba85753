"""Gives one importer mutated files, guided by what code they reach; a process of its own.

``python -m benchmarks.fuzz_child NAME N_RUNS FOLDER SEED``. Half of the files are libFuzzer's work
(by atheris), half of them `benchmarks.mutating`'s. What is neither read nor refused is kept in
FOLDER and counted; what hangs or crashes ends the process, and libFuzzer keeps the file there.
"""

import json
import random
import resource
import sys
import time
import traceback
from collections import Counter
from pathlib import Path

import atheris
import numpy as np

from benchmarks.mutating import mutate

PROJECT = Path(__file__).parents[1]
MOST_SECONDS = 10.0
"""Of processor time, for a file of a few kilobytes."""
SECONDS_TO_HANG = 300
"""By the clock, on a computer that does other things, too."""
MOST_MEMORY_MB = 2048
"""More than the process has when it begins."""
LEAST_LENGTH = 4096
RUNS_BETWEEN_NOTES = 100


def _compiled_modules() -> list[str]:
    """Return the modules whose functions are compiled, and cannot be watched from Python."""
    files = (PROJECT / "adibas").rglob("*kernels.py")
    return [".".join(file.relative_to(PROJECT).with_suffix("").parts) for file in files]


with atheris.instrument_imports(include=["adibas"], exclude=_compiled_modules()):
    from benchmarks.fuzz_importers import Importer, Trial, importer_named


class Fuzzing:
    """Counts what becomes of the files of one importer."""

    def __init__(self, importer: Importer, folder: Path) -> None:
        self._folder = folder
        self._trial = Trial(importer)
        self._is_text = importer.is_text
        self._counts: Counter[str] = Counter()
        self.whole = self._trial.whole
        for data in self.whole:  # loads and compiles what is needed, before anything is measured
            self._trial.give(data)

    def give(self, data: bytes) -> None:
        """Let the importer read one file."""
        start_s = time.process_time()
        try:
            self._counts[self._trial.give(data)] += 1
            if time.process_time() - start_s > MOST_SECONDS:
                self._note_fault("slow", data)
        except Exception as error:  # noqa: BLE001  (every one of them is a finding)
            self._keep(error, data)
        if sum(self._counts.values()) % RUNS_BETWEEN_NOTES == 0:
            self.note()

    def note(self) -> None:
        """Write down how many there were."""
        unfinished = self._folder / "counts.part"
        unfinished.write_text(json.dumps(self._counts), encoding="utf-8")
        unfinished.replace(self._folder / "counts.json")

    def mutated(self, data: bytes, most_bytes: int, seed: int) -> bytes:
        """Return another file."""
        rng = random.Random(seed)  # noqa: S311  (nothing secret)
        if rng.random() < 0.5:
            return bytes(atheris.Mutate(data, most_bytes))
        return mutate(data, rng, is_text=self._is_text)[:most_bytes]

    def _keep(self, error: BaseException, data: bytes) -> None:
        places = [
            frame
            for frame in traceback.extract_tb(error.__traceback__)
            if "adibas" in frame.filename
        ]
        where = f"{Path(places[-1].filename).stem}-{places[-1].lineno}" if places else "outside"
        self._note_fault(f"{type(error).__name__}-{where}", data)

    def _note_fault(self, name: str, data: bytes) -> None:
        self._counts[f"fault {name}"] += 1
        path = self._folder / f"{name}.fault"
        if not path.exists():
            path.write_bytes(data)


def main() -> None:
    """Give the files and end the process."""
    name, n_runs, folder, seed = sys.argv[1], int(sys.argv[2]), Path(sys.argv[3]), int(sys.argv[4])
    fuzzing = Fuzzing(importer_named(name), folder)
    corpus = folder / "corpus"
    corpus.mkdir(exist_ok=True)
    for number, data in enumerate(fuzzing.whole):
        (corpus / f"whole-{number}").write_bytes(data)
    virtual_bytes = resource.getpagesize() * int(Path("/proc/self/statm").read_text().split()[0])
    most_bytes = virtual_bytes + MOST_MEMORY_MB * 2**20
    resource.setrlimit(resource.RLIMIT_AS, (most_bytes, resource.RLIM_INFINITY))
    longest = max(LEAST_LENGTH, 2 * max(len(data) for data in fuzzing.whole))
    options = (
        f"-runs={n_runs}", f"-seed={seed}", f"-max_len={longest}", "-len_control=0",
        f"-timeout={SECONDS_TO_HANG}", f"-rss_limit_mb={2 * MOST_MEMORY_MB}",
        f"-artifact_prefix={folder}/libfuzzer-", "-verbosity=0",
    )  # fmt: skip
    np.seterr(all="ignore")
    atheris.Setup(
        [sys.argv[0], *options, str(corpus)], fuzzing.give, custom_mutator=fuzzing.mutated
    )
    atheris.Fuzz()


if __name__ == "__main__":
    main()
