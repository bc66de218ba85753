"""Compiling before somebody waits: once, in a process of its own, and noted."""

from adibas.pipeline import warming


def test_the_hot_loops_are_compiled_once_and_noted(tmp_path):
    process = warming.start_warming(tmp_path)
    process.join()
    assert process.exitcode == 0
    (note,) = tmp_path.iterdir()
    assert "numba" in note.name
    assert warming.start_warming(tmp_path) is None


def test_another_version_compiles_anew(tmp_path, monkeypatch):
    monkeypatch.setattr(warming.adibas, "__version__", "0.0.1")
    older = warming._note(tmp_path)
    monkeypatch.undo()
    assert warming._note(tmp_path) != older
