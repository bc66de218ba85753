"""Every text of the program stands in the catalogue of each language, with the same fields."""

import argparse
import ast
import gettext
import importlib
import inspect
import re
import string
import subprocess
import sys
from functools import cache

import pytest
from babel.messages.mofile import read_mo

from adibas.cli.command_line import COMMANDS
from adibas.data.corrections import LONGEST_LABEL
from adibas.data.landmark_texts import KNOWN, landmark_text
from adibas.texts import LANGUAGES, Message, Texts, speaking
from installers.translations import (
    ARGPARSE_MESSAGES,
    catalogue_path,
    collected,
    error_names,
    functions_with_message_id,
    read_catalogue,
    source_files,
)

TRANSLATED = [language for language in LANGUAGES if language != "en"]
PERCENT_FIELD = re.compile(r"%(?:\(\w+\))?[srd]")

FOR_PROGRAMMERS = {
    ".__call__() not defined",
    "%r is not callable",
    "'required' is an invalid argument for positionals",
    'argument "-" with mode %r',
    "can't open '%(filename)s': %(error)s",
    "cannot have multiple subparser arguments",
    "cannot merge actions - two groups are named %r",
    "conflicting option string: %s",
    "conflicting subparser alias: %s",
    "conflicting subparser: %s",
    "dest= is required for options like %r",
    "invalid conflict_resolution value: %r",
    "invalid option string %(option)r: must start with a character %(prefix_chars)r",
    "mutually exclusive arguments must be optional",
    "show program's version number and exit",
}
"""What argparse says of a wrong parser, or what our parser replaces."""


@pytest.fixture(scope="module")
def template():
    return collected()


def forms(text):
    """Return the singular and the plurals, or the only form."""
    return text if isinstance(text, tuple | list) else (text,)


def pairs(message):
    """Return every written form of a translation beside the form of the source it stands for."""
    source, translation = forms(message.id), forms(message.string)
    placed = [(source[min(i, len(source) - 1)], form) for i, form in enumerate(translation)]
    return [(source_form, form) for source_form, form in placed if form]


def fields(text, *, is_percent):
    """Return the places that are filled in, with their formats."""
    if is_percent:
        return sorted(PERCENT_FIELD.findall(text))
    return sorted(
        (name, spec, how) for _, name, spec, how in string.Formatter().parse(text) if name
    )


def as_forms(catalogue):
    """Return the forms of every translated text and of its translation."""
    all_forms = {tuple(forms(m.id)): tuple(forms(m.string)) for m in catalogue if m.id}
    return {source: translation for source, translation in all_forms.items() if all(translation)}


def is_of_argparse(message):
    return message.id in ARGPARSE_MESSAGES


@pytest.mark.parametrize("language", TRANSLATED)
def test_every_text_stands_in_the_catalogue_and_none_that_is_gone(template, language):
    asked = {message.id for message in template if message.id}
    there = {message.id for message in read_catalogue(language) if message.id}
    assert sorted(map(str, asked - there)) == [], "run `make translations` and translate these"
    assert sorted(map(str, there - asked)) == [], "run `make translations`: these are gone"
    assert not read_catalogue(language).obsolete


@pytest.mark.parametrize("language", TRANSLATED)
def test_every_text_is_translated_for_sure(language):
    catalogue = read_catalogue(language)
    assert [m.id for m in catalogue if m.id and not all(forms(m.string))] == []
    assert [m.id for m in catalogue if m.id and m.fuzzy] == []


@pytest.mark.parametrize("language", TRANSLATED)
def test_translations_fill_in_exactly_the_fields_of_their_source(language):
    wrong = [
        form
        for message in read_catalogue(language)
        if message.id
        for source, form in pairs(message)
        if fields(source, is_percent=is_of_argparse(message))
        != fields(form, is_percent=is_of_argparse(message))
    ]
    assert wrong == []


@pytest.mark.parametrize("language", TRANSLATED)
def test_translations_begin_and_end_as_their_source(language):
    """A sentence stays a sentence, a label a label, and spaces that join stay."""
    wrong = [
        form
        for message in read_catalogue(language)
        if message.id
        for source, form in pairs(message)
        if source[-1] != form[-1] and {source[-1], form[-1]} & set(".:? \n…")
    ]
    assert wrong == []


@pytest.mark.parametrize("language", TRANSLATED)
def test_what_has_a_key_in_the_source_has_one_in_the_translation(language):
    """`&Language` is reached with Alt+L: a translation offers a key as well."""
    key = re.compile(r"&\w")
    wrong = [
        form
        for message in read_catalogue(language)
        if message.id
        for source, form in pairs(message)
        if len(key.findall(source)) != len(key.findall(form))
    ]
    assert wrong == []


@pytest.mark.parametrize("language", TRANSLATED)
def test_the_compiled_catalogue_is_the_written_one(language):
    with catalogue_path(language, ".mo").open("rb") as file:
        compiled = read_mo(file)
    assert as_forms(compiled) == as_forms(read_catalogue(language))


@cache
def parsed(file):
    return ast.parse(file.read_text(encoding="utf-8"))


def calls(tree):
    """Yield (name, call) of every call of a name or an attribute."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            function = node.func
            if isinstance(function, ast.Name):
                yield function.id, node
            elif isinstance(function, ast.Attribute):
                yield function.attr, node


def is_constant_text(node):
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def takes_message_id(function):
    return isinstance(function, ast.FunctionDef) and any(
        argument.arg == "message_id" for argument in function.args.args
    )


def handed_on(tree):
    """Return the nodes inside functions that take a message id and hand it on."""
    return {
        id(node)
        for function in ast.walk(tree)
        if takes_message_id(function)
        for node in ast.walk(function)
    }


def test_every_error_about_the_world_has_a_constant_sentence():
    wrong = []
    places = dict.fromkeys(error_names(), 1) | functions_with_message_id()
    for file in source_files():
        tree = parsed(file)
        named = [(name, call) for name, call in calls(tree) if name in places]
        may_hand_on = handed_on(tree) if named else set()
        for name, call in named:
            if not (len(call.args) >= places[name]):
                wrong.append(f"{file.name}:{call.lineno} says nothing")
            else:
                sentence = call.args[places[name] - 1]
                is_handed_on = id(call) in may_hand_on and isinstance(sentence, ast.Name)
                is_of_other = ast.unparse(sentence) == "error.message_id"
                if not (is_constant_text(sentence) or is_handed_on or is_of_other):
                    wrong.append(f"{file.name}:{call.lineno} {ast.unparse(sentence)}")
    assert wrong == []


def test_no_text_is_put_together_before_it_is_translated():
    """`_` takes a constant, or the name of one that `message` marks; never an f-string."""
    wrong = []
    for file in source_files():
        for name, call in calls(parsed(file)):
            if name in {"_", "translate_plural", "message"} and call.args:
                n_texts = 2 if name == "translate_plural" else 1
                for text in call.args[:n_texts]:
                    may_be = (ast.Name, ast.Attribute, ast.Subscript) if name == "_" else ()
                    if not is_constant_text(text) and not isinstance(text, may_be):
                        wrong.append(f"{file.name}:{call.lineno} {ast.unparse(text)}")
    assert wrong == []


SHOWN_BY = {
    *("setText", "setToolTip", "setWindowTitle", "setTitle", "setPlaceholderText", "setPrefix"),
    *("setSuffix", "setSpecialValueText", "setAccessibleName", "setAccessibleDescription"),
    *("addItem", "addTab", "addAction", "addMenu", "addRow", "setTabText", "setItemText"),
    *("QLabel", "QPushButton", "QToolButton", "QCheckBox", "QRadioButton", "QGroupBox", "QAction"),
    *("add_argument_group", "say"),
}
"""What shows its arguments to the user."""


def words(text):
    """Return the words of a constant text; of an f-string, those between its fields."""
    parts = text.values if isinstance(text, ast.JoinedStr) else [text]
    constant = " ".join(part.value for part in parts if is_constant_text(part))
    return re.findall(r"[^\W\d_]{2,}", constant)


def test_nothing_is_shown_that_no_catalogue_can_hold():
    wrong = [
        f"{file.name}:{call.lineno} {ast.unparse(text)}"
        for file in source_files()
        for name, call in calls(parsed(file))
        if name in SHOWN_BY
        for text in call.args
        if set(words(text)) - {"ADiBAS", "RealSense"}
    ]
    assert wrong == []


def test_every_command_is_summed_up_in_every_language():
    summaries = [importlib.import_module(f"adibas.cli.{name}").SUMMARY for name in COMMANDS]
    assert [text for text in summaries if not isinstance(text, Message)] == []


def test_no_placeholder_of_an_option_is_an_english_word():
    """``N`` and ``U,V`` may stand for themselves; ``FILE`` is a word."""
    wrong = [
        f"{file.name}:{keyword.value.lineno} {keyword.value.value}"
        for file in source_files()
        for _name, call in calls(parsed(file))
        for keyword in call.keywords
        if keyword.arg in {"metavar", "help", "description", "title", "label"}
        and is_constant_text(keyword.value)
        and re.search(r"^[A-Z]{3,}| ", keyword.value.value)
    ]
    assert wrong == []


def argparse_texts():
    """Return what the argparse of this Python looks up."""
    found = set()
    for name, call in calls(ast.parse(inspect.getsource(argparse))):
        if name in {"_", "ngettext"} and is_constant_text(call.args[0]):
            found.add(call.args[0].value)
    return found


def test_argparse_says_nothing_that_is_not_translated():
    known = {forms(text)[0] for text in ARGPARSE_MESSAGES}
    assert "usage: " in argparse_texts()
    assert argparse_texts() - known - FOR_PROGRAMMERS == set()


@pytest.mark.parametrize(
    ("variable", "tag", "first_word", "sentence"),
    [
        (
            "LANGUAGE",
            "es_MX",
            "uso:",
            "Postura y movimiento medidos con una cámara de profundidad.",
        ),
        ("LC_ALL", "ca_ES@valencia", "ús:", "mostrar aquesta ajuda i sortir"),
        ("LC_ALL", "pt_BR.UTF-8", "uso:", "mostrar esta ajuda e sair"),
        ("LC_ALL", "C", "usage:", "show this help message and exit"),
    ],
)
def test_the_command_line_speaks_the_language_of_the_environment(
    monkeypatch, variable, tag, first_word, sentence
):
    monkeypatch.delenv("LANGUAGE")
    monkeypatch.setenv(variable, tag)
    program = "from adibas.cli import main; main(['--help'])"
    done = subprocess.run(
        [sys.executable, "-X", "utf8", "-c", program],
        capture_output=True,
        encoding="utf-8",
        check=True,
    )
    assert done.stdout.startswith(first_word)
    assert sentence in " ".join(done.stdout.split())


@pytest.mark.parametrize(
    ("language", "expected"),
    [("es_MX", "Ángulos"), ("ca@valencia", "Angles"), ("pt_BR", "Ângulos")],
)
def test_the_window_may_ask_for_a_region(language, expected):
    assert Texts(language).translate("Angles") == expected


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_names_of_landmarks_fit_a_marker_and_differ(language):
    with speaking(language):
        names = [landmark_text(label) for label in KNOWN]
    assert [name for name in names if len(name) > LONGEST_LABEL] == []
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("language", TRANSLATED)
def test_gettext_reads_the_catalogues_with_their_plurals(language):
    with catalogue_path(language, ".mo").open("rb") as file:
        catalogue = gettext.GNUTranslations(file)
    one = catalogue.ngettext("expected %s argument", "expected %s arguments", 1)
    two = catalogue.ngettext("expected %s argument", "expected %s arguments", 2)
    assert one != two
