"""Compiling before somebody waits: once, in a process of its own, and noted."""

import subprocess
import sys

from adibas.pipeline import warming


def test_the_hot_loops_are_compiled_once_and_noted(tmp_path):
    process = warming.start_warming(tmp_path)
    process.join()
    assert process.exitcode == 0
    (note,) = tmp_path.iterdir()
    assert "numba" in note.name
    assert warming.start_warming(tmp_path) is None


WITHOUT_CODE = """
import importlib, pkgutil
import adibas
from adibas.pipeline import warming

for work in warming.WORKS:
    work()
names = {}
for found in pkgutil.walk_packages(adibas.__path__, "adibas."):
    if ".migrations." not in found.name:
        for name, loop in vars(importlib.import_module(found.name)).items():
            if hasattr(loop, "py_func") and loop.py_func.__module__ == found.name:
                names[loop] = f"{found.name}.{name}"
called = [loop for loop in names if loop.signatures]
while called:  # what is kept on the disk has in it what it calls itself
    code = called.pop()
    if names.pop(code, None):
        function = code.py_func
        others = [function.__globals__.get(name) for name in function.__code__.co_names]
        called += [one for one in others if hasattr(one, "py_func")]
print(*names.values())
"""
OF_DEVELOPERS = (
    "adibas.alignment.registration_kernels.nearest_pixels",  # benchmarks
    "adibas.calibration.corner_gradient_kernels.",  # `--corners gradient`, to compare with
    "adibas.context.kernels.",  # training
    "adibas.forests.training_kernels.",
    "adibas.graphcut.move_kernels.begin_swap",  # `--cut omega_2`, to compare with
    "adibas.simulation.furnished_room_kernels.",  # benchmarks
    "adibas.simulation.marker_kernels.place_balls",
    "adibas.simulation.raster._weigh",  # training
)


def test_no_hot_loop_is_left_to_compile_but_those_of_training_and_studies():
    run = [sys.executable, "-W", "error", "-c", WITHOUT_CODE]
    said = subprocess.run(run, capture_output=True, text=True, check=True).stdout
    assert [name for name in said.split() if not name.startswith(OF_DEVELOPERS)] == []


def test_another_version_compiles_anew(tmp_path, monkeypatch):
    monkeypatch.setattr(warming.adibas, "__version__", "0.0.1")
    older = warming._note(tmp_path)
    monkeypatch.undo()
    assert warming._note(tmp_path) != older
