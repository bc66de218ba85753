"""Analyses a table of joints in a process of its own; prints processor seconds and peak MB."""

import json
import sys
import time
from pathlib import Path

from adibas.pipeline.behaviour import BehaviourRequest, analyse_behaviour
from adibas.resources import resource_path
from benchmarks.process_memory import peak_memory_mib


def main(joints: str) -> None:
    """Measure one analysis, with the five gestures of the shipped model."""
    start = time.process_time()
    request = BehaviourRequest(Path(joints), (resource_path("models", "gestures.json"),))
    analyse_behaviour(request, lambda _done, _total: None)
    spent_s = time.process_time() - start
    print(json.dumps({"seconds": spent_s, "mb": peak_memory_mib()}))  # noqa: T201


if __name__ == "__main__":
    main(sys.argv[1])
