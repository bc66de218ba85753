"""What the frozen program does before it begins."""

import os
import subprocess
import sys

import pytest

from installers.start import give_libraries_back

SAYS = [sys.executable, "-c", "import os; print(os.environ.get('LD_LIBRARY_PATH'))"]


@pytest.mark.parametrize(
    ("given", "is_frozen", "expected"),
    [
        ({"LD_LIBRARY_PATH": "/ours"}, True, "None"),
        ({"LD_LIBRARY_PATH": "/ours", "LD_LIBRARY_PATH_ORIG": "/mine"}, True, "/mine"),
        ({"LD_LIBRARY_PATH": "/mine"}, False, "/mine"),
        ({}, True, "None"),
    ],
)
def test_programs_that_it_starts_load_their_own_libraries(monkeypatch, given, is_frozen, expected):
    for name in ("LD_LIBRARY_PATH", "LD_LIBRARY_PATH_ORIG"):
        monkeypatch.delenv(name, raising=False)
    for name, value in given.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys, "frozen", is_frozen, raising=False)
    give_libraries_back()
    assert "LD_LIBRARY_PATH_ORIG" not in os.environ
    done = subprocess.run(SAYS, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == expected
