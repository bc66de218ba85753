"""The memory that the benchmark of the live chain tells is that of its own process."""

import multiprocessing
import sys
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

from benchmarks.process_memory import peak_memory_mib

PARENT_MIB = 500


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells it so")
def test_memory_is_not_that_of_the_process_that_started_it():
    held = np.ones(PARENT_MIB * 2**20, np.uint8)
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as process:
        told_mib = process.submit(peak_memory_mib).result()
    assert peak_memory_mib() > held.nbytes / 2**20 > told_mib > 0
