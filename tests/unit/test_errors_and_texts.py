"""Failures of the world read as sentences, in the user's language."""

import struct
from threading import Thread

import pytest

from adibas.errors import AdibasError, RecordingError
from adibas.texts import (
    Texts,
    decimal_text,
    describe,
    message,
    speaking,
    spoken,
    system_language,
)


def write_catalogue(folder, texts):
    """Write a binary gettext catalogue (its documented layout) with `texts`."""
    entries = sorted({"": "Content-Type: text/plain; charset=UTF-8\n", **texts}.items())
    pairs = [(key.encode(), value.encode()) for key, value in entries]
    offset = 28 + 16 * len(pairs)
    tables, blob = [b"", b""], b""
    for side in (0, 1):
        for pair in pairs:
            tables[side] += struct.pack("<II", len(pair[side]), offset + len(blob))
            blob += pair[side] + b"\0"
    header = struct.pack("<7I", 0x950412DE, 0, len(pairs), 28, 28 + 8 * len(pairs), 0, 0)
    folder.mkdir(parents=True)
    (folder / "adibas.mo").write_bytes(header + tables[0] + tables[1] + blob)


def test_an_error_says_what_failed_on_which_thing():
    error = RecordingError("{file} is cut short. Record again.", file="a.mcap")
    assert str(error) == "a.mcap is cut short. Record again."
    assert isinstance(error, AdibasError)


def test_an_error_is_told_in_the_language_in_use(tmp_path, monkeypatch):
    message = "{file} is cut short. Record again."
    spanish = "{file} está cortado. Grabe de nuevo."
    write_catalogue(tmp_path / "es" / "LC_MESSAGES", {message: spanish})
    monkeypatch.setattr("adibas.texts.resource_path", lambda _name: tmp_path)
    texts = Texts("es")
    assert texts.describe(RecordingError(message, file="a.mcap")) == (
        "a.mcap está cortado. Grabe de nuevo."
    )


def test_a_language_without_catalogue_falls_back_to_english():
    texts = Texts("xx")
    assert texts.translate("Summary") == "Summary"
    assert texts.translate_plural("{n} frame", "{n} frames", 2) == "{n} frames"


def test_one_block_speaks_another_language_and_other_threads_do_not(tmp_path, monkeypatch):
    write_catalogue(tmp_path / "es" / "LC_MESSAGES", {"Summary": "Resumen"})
    monkeypatch.setattr("adibas.texts.resource_path", lambda _name: tmp_path)
    texts = Texts("en")
    elsewhere = []
    with texts.speaking("es"):
        other = Thread(target=lambda: elsewhere.append(texts.translate("Summary")))
        other.start()
        other.join()
        with texts.speaking("en"):
            assert texts.translate("Summary") == "Summary"
        assert (texts.translate("Summary"), texts.language) == ("Resumen", "es")
    assert elsewhere == ["Summary"]
    assert (texts.translate("Summary"), texts.language) == ("Summary", "en")


def test_a_block_that_fails_leaves_its_language(tmp_path, monkeypatch):
    monkeypatch.setattr("adibas.texts.resource_path", lambda _name: tmp_path)
    texts = Texts("ca")
    with pytest.raises(KeyError), texts.speaking("es-MX"):
        assert texts.language == "es"
        raise KeyError
    assert texts.language == "ca"


@pytest.mark.parametrize(
    ("language", "expected"),
    [
        ("es_ES.UTF-8", "es"),
        ("es_MX", "es"),
        ("ca:es", "ca"),
        ("ca@valencia", "ca"),
        ("ca-ES-valencia", "ca"),
        ("fr:es", "es"),
        ("pt_BR.UTF-8", "pt"),
        ("pt-PT", "pt"),
        ("fr", "en"),
        ("C", "en"),
        ("en", "en"),
    ],
)
def test_the_environment_chooses_the_language(monkeypatch, language, expected):
    monkeypatch.setenv("LANGUAGE", language)
    assert system_language() == expected


@pytest.mark.parametrize("variable", ["LC_ALL", "LC_MESSAGES", "LANG"])
def test_without_a_list_of_languages_the_locale_chooses(monkeypatch, variable):
    for name in ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv(variable, "ca_ES.UTF-8")
    assert system_language() == "ca"


def test_without_any_variable_the_system_is_asked(monkeypatch):
    for name in ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("adibas.texts.locale.getlocale", lambda: ("Spanish_Spain", "1252"))
    assert system_language() == "es"
    monkeypatch.setattr("adibas.texts.locale.getlocale", lambda: ("Portuguese_Brazil", "1252"))
    assert system_language() == "pt"
    monkeypatch.setattr("adibas.texts.locale.getlocale", lambda: (None, None))
    assert system_language() == "en"


def test_a_marked_field_of_an_error_is_translated_and_any_other_is_not(tmp_path, monkeypatch):
    write_catalogue(
        tmp_path / "es" / "LC_MESSAGES", {"colour": "color", "{a} and {b}": "{a} y {b}"}
    )
    monkeypatch.setattr("adibas.texts.resource_path", lambda _name: tmp_path)
    error = RecordingError("{a} and {b}", a=message("colour"), b="colour")
    assert Texts("es_MX").describe(error) == "color y colour"


def test_no_text_stays_no_text(tmp_path, monkeypatch):
    write_catalogue(tmp_path / "es" / "LC_MESSAGES", {"colour": "color"})
    monkeypatch.setattr("adibas.texts.resource_path", lambda _name: tmp_path)
    assert Texts("es").translate("") == ""


@pytest.mark.parametrize(
    ("language", "text"),
    [("en", "1234.57"), ("es", "1234,57"), ("ca", "-0,06"), ("pt", "-0,06"), ("en", "-0.06")],
)
def test_numbers_on_paper_have_the_decimal_mark_of_the_language(language, text):
    with speaking(language):
        assert decimal_text(float(text.replace(",", ".")), 2) == text


def test_what_is_rounded_to_nothing_has_no_sign():
    assert [decimal_text(value, 1) for value in (-0.04, -0.06, 0.04)] == ["0.0", "-0.1", "0.0"]


@pytest.mark.parametrize(
    ("language", "text"), [("en", "-1.25 of 3 in 0.5"), ("pt", "-1,25 of 3 in 0,5")]
)
def test_numbers_in_sentences_have_the_decimal_mark_of_the_language(language, text):
    with speaking(language):
        assert f"{spoken(-1.25):.2f} of {spoken(3)} in {spoken(0.5)}" == text
        error = RecordingError("{file} lasts {seconds:.2f} s.", file="a.b", seconds=-1.25)
        assert describe(error) == f"a.b lasts {text.split()[0]} s."
