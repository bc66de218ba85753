"""Preferences survive a restart, and a file that somebody broke."""

import json

import pytest

from ui.preferences import FONT_SCALES, Preferences, PreferencesFile


@pytest.fixture
def path(tmp_path):
    return tmp_path / "config" / "preferences.json"


def read(path, text):
    path.parent.mkdir(exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return PreferencesFile(path).now


def test_changes_are_told_and_kept(path):
    file, told = PreferencesFile(path), []
    file.changed.subscribe(told.append)
    file.change(theme="dark", font_scale=1.5, splitters={"review-1": "00ff"})
    file.change(theme="dark")
    assert told == [file.now]
    assert PreferencesFile(path).now == file.now
    assert (file.now.theme, file.now.font_scale) == ("dark", 1.5)


def test_without_a_file_the_desktop_chooses_the_language(path, monkeypatch):
    monkeypatch.setenv("LANGUAGE", "ca_ES:es")
    assert PreferencesFile(path).now.language == "ca"


@pytest.mark.parametrize("text", ["", "{", "[1]", "null", "[" * 100_000, '{"theme": 7}', "\x00"])
def test_a_broken_file_means_the_usual_preferences(path, text):
    now = read(path, text)
    assert now.theme == Preferences().theme
    assert now.language


@pytest.mark.parametrize(
    ("wrong", "name", "put_right"),
    [
        ({"theme": "pink"}, "theme", "system"),
        ({"language": "tlh"}, "language", "en"),
        ({"font_scale": 9.0}, "font_scale", FONT_SCALES[-1]),
        ({"font_scale": 1.3}, "font_scale", 1.25),
        ({"font_scale": float("nan")}, "font_scale", 1.0),
        ({"autolock_minutes": -3}, "autolock_minutes", 0),
        ({"countdown_s": 999}, "countdown_s", 60),
        ({"burst_frames": 0}, "burst_frames", 1),
        ({"calibration_days": 0}, "calibration_days", 1),
        ({"splitters": {"a": 1}}, "splitters", {"a": "1"}),
        ({"unknown": 1}, "operator", ""),
    ],
)
def test_what_makes_no_sense_is_put_right(path, wrong, name, put_right, monkeypatch):
    monkeypatch.setenv("LANGUAGE", "en")
    assert getattr(read(path, json.dumps(wrong)), name) == put_right


def test_a_folder_that_cannot_be_written_keeps_them_until_the_end(tmp_path, caplog):
    (tmp_path / "config").write_text("a file stands here")
    file = PreferencesFile(tmp_path / "config" / "preferences.json")
    file.change(theme="dark")
    assert file.now.theme == "dark"
    assert "cannot be written" in caplog.text
