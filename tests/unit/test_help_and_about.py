"""Help and notices are there in every language, offline, and name what the program rests on."""

import re
import tomllib
from importlib.metadata import metadata
from pathlib import Path

import pytest

from adibas.resources import resource_path
from adibas.texts import LANGUAGES

PAGES = {
    "start",
    "patients",
    "capture",
    "markers",
    "review",
    "reports",
    "comparison",
    "behaviour",
    "calibration",
    "settings",
}
ROOT = Path(__file__).parents[2]
ROW = re.compile(r"^\| (\S+) \| ([^|]+) \|$", re.MULTILINE)


def page(language, name):
    return resource_path("help", language, f"{name}.md").read_text(encoding="utf-8")


def about(language):
    return resource_path("about", f"{language}.md").read_text(encoding="utf-8")


def outline(text):
    """Return what a page is made of: headings, steps, points and rows of tables."""
    kinds = [re.match(r"(#+ |\d\. |- |\|)", line) for line in text.splitlines()]
    return [kind.group(1) for kind in kinds if kind]


def licences(text):
    """Return licence by package; the row of titles is no package."""
    return {name: licence for name, licence in ROW.findall(text) if not set(name) <= set("-|")}


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_language_has_every_page(language):
    there = {path.stem for path in resource_path("help", language).glob("*.md")}
    assert there == PAGES


@pytest.mark.parametrize("name", sorted(PAGES))
@pytest.mark.parametrize("language", LANGUAGES)
def test_a_page_says_as_much_in_every_language(language, name):
    assert len(page(language, name).split()) > 100
    assert outline(page(language, name)) == outline(page("en", name))


@pytest.mark.parametrize("language", LANGUAGES)
def test_no_page_leads_to_the_network(language):
    texts = [about(language), *(page(language, name) for name in PAGES)]
    assert [text for text in texts if re.search(r"https?:|www\.|\]\(", text)] == []


@pytest.mark.parametrize(
    ("language", "words"),
    [
        ("en", "not for diagnosis"),
        ("es", "No sirve para el diagnóstico"),
        ("ca", "No serveix per al diagnòstic"),
        ("pt", "Não serve para diagnóstico"),
    ],
)
def test_intended_use_and_licence_are_told(language, words):
    assert words in about(language)
    assert words.lower() in page(language, "start").lower()
    assert "GPL-3.0-or-later" in about(language)
    assert outline(about(language)) == outline(about("en"))


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_licence_of_every_dependency_is_named(language):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    dependencies = {re.split(r"[<>=!\[; ]", one)[0] for one in project["dependencies"]}
    named = licences(about(language))
    titles = {"Package", "Paquete", "Paquet", "Pacote"}
    assert set(named) - titles == dependencies
    assert [named[name] for name in sorted(dependencies)] == [
        licences(about("en"))[name] for name in sorted(dependencies)
    ]


def test_the_licences_are_those_that_the_packages_declare():
    """Where a package declares an SPDX expression, its first licence is the one that is named."""
    named = licences(about("en"))
    declared = {
        name: metadata(name).get("License-Expression") for name in named if name != "Package"
    }
    first = {name: text.split()[0] for name, text in declared.items() if text}
    assert len(first) > 5
    assert {name for name, text in first.items() if not named[name].startswith(text)} == set()
