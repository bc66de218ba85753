"""The manual says the same in every language, by the window's own names, and builds offline."""

import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from babel.messages.pofile import read_po
from PIL import Image

from adibas.measures.protocol_store import find_protocol
from adibas.resources import resource_path
from adibas.texts import LANGUAGES
from installers.bundle import ROOT
from installers.manual.figures import FOLDER, all_figures, spread
from installers.manual.hooks import help_part, section_of, with_list_breaks
from installers.manual.landmarks import PROTOCOLS, figure_views, numbered
from installers.manual.pictures import MANUAL, PICTURES, picture_path
from installers.manual.words import WORDS
from installers.studio import SIZE
from ui.manual import PAGES

PAGE_NAMES = sorted(path.name for path in (MANUAL / "en").glob("*.md"))
BOLD = re.compile(r"\*\*(.+?)\*\*", re.DOTALL)
ANCHOR = re.compile(r"\{: #([\w-]+) \}")
LINK = re.compile(r"\]\(([^)]+)\)")
PICTURE = re.compile(r"\((?:\.\./\w+/)?pictures/([\w-]+)\.webp\)")
OTHERS = [one for one in LANGUAGES if one != "en"]
FENCE = re.compile(r"```\n(.*?)```", re.DOTALL)
PART = re.compile(r"<(?:h[1-6]|p|li|tr|pre|img)\b")
SHOWN = re.compile(r"<img[^>]* src=\"([^\"]+)\"|<pre[^>]*>(.*?)</pre>", re.DOTALL)
OUTLINE = re.compile(r"(#+ |\d+\. |- |\||```|!\[|\{\{ .*)")
FROM_ELSEWHERE = re.compile(r"(?:src|href)=\"(?:\w+:)?//|@import|url\(")
COLOR = re.compile(r"--([\w-]+): (#[0-9A-F]{6})")
SAME_PICTURE = 3.0
"""Mean difference of grey values: letters are drawn a little otherwise on other machines."""


def text_of(language, name):
    return (MANUAL / language / name).read_text(encoding="utf-8")


def catalogue(language):
    """Return the window's texts as a reader sees them, without underlined letters and dots."""
    return {seen(to) for pairs in translations(language).values() for to in pairs}


@cache
def translations(language):
    """Return what each English text of the window is in a language; one may be several."""
    path = resource_path("translations", "es" if language == "en" else language)
    with (path / "LC_MESSAGES" / "adibas.po").open("rb") as file:
        entries = [one for one in read_po(file) if one.id and isinstance(one.id, str)]
    found = {}
    for one in entries:
        found.setdefault(seen(one.id), set()).add(seen(one.id if language == "en" else one.string))
    return found


def size_of(path):
    with Image.open(path) as image:
        return image.size


def grey_values(path):
    with Image.open(path) as image:
        return np.asarray(image.convert("L"), float)


def seen(text):
    return " ".join(text.replace("&", "").removesuffix("...").split())


def outline(text):
    lines = [OUTLINE.match(line) for line in text.splitlines()]
    return [line.group(1) for line in lines if line]


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_language_has_every_page(language):
    assert sorted(path.name for path in (MANUAL / language).glob("*.md")) == PAGE_NAMES


@pytest.mark.parametrize("name", PAGE_NAMES)
@pytest.mark.parametrize("language", OTHERS)
def test_a_page_says_as_much_in_every_language(language, name):
    english, translated = text_of("en", name), text_of(language, name)
    assert outline(translated) == outline(english)
    assert FENCE.findall(translated) == FENCE.findall(english)
    assert PICTURE.findall(translated) == PICTURE.findall(english)
    assert translated.count("**") == english.count("**")
    assert ANCHOR.findall(translated) == ANCHOR.findall(english)
    assert LINK.findall(translated) == LINK.findall(english)
    assert translated != english


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_bold_name_is_one_that_the_window_shows(language):
    known = catalogue(language)
    for name in PAGE_NAMES:
        unknown = {one for one in BOLD.findall(text_of(language, name)) if seen(one) not in known}
        assert not unknown, f"{language}/{name}"


@pytest.mark.parametrize("name", PAGE_NAMES)
@pytest.mark.parametrize("language", OTHERS)
def test_a_page_names_the_same_buttons_in_every_language(language, name):
    """A name of the window that is another button's would lead somewhere else."""
    english = {seen(one) for one in BOLD.findall(text_of("en", name))}
    translated = {seen(one) for one in BOLD.findall(text_of(language, name))}
    known = translations(language)
    assert {one for one in english if not known[one] & translated} == set()
    assert translated <= {to for one in english for to in known[one]}


def test_a_bold_name_in_the_developers_part_is_one_that_the_window_shows():
    known = catalogue("en") | {"bold"}
    for path in sorted((MANUAL / "developers").glob("*.md")):
        names = BOLD.findall(path.read_text(encoding="utf-8"))
        assert {one for one in names if seen(one) not in known} == set(), path.name


def test_every_picture_is_drawn_by_the_program_and_every_one_that_is_drawn_is_shown():
    for language in LANGUAGES:
        shown = {one for name in PAGE_NAMES for one in PICTURE.findall(text_of(language, name))}
        assert shown == set(PICTURES)
        there = {path.stem for path in (MANUAL / language / "pictures").iterdir()}
        assert there == set(PICTURES)
        assert {size_of(picture_path(language, name)) for name in PICTURES} == {SIZE}


def test_the_figures_are_those_that_the_protocols_and_the_body_give():
    drawn = dict(all_figures())
    assert {path.stem for path in FOLDER.iterdir()} == set(drawn)
    for name, image in drawn.items():
        kept = grey_values(FOLDER / f"{name}.png")
        anew = np.asarray(image.convert("L"), float)
        assert kept.shape == anew.shape, name
        assert np.abs(kept - anew).mean() < SAME_PICTURE, name


@pytest.mark.parametrize("protocol_id", PROTOCOLS)
def test_a_figure_has_every_landmark_of_its_view_once_and_on_the_patients_side(protocol_id):
    protocol = find_protocol(protocol_id)
    for view in figure_views(protocol):
        found = numbered(protocol_id, view)
        wanted = {one.landmark_id for one in protocol.landmarks if view in one.views}
        assert {one.landmark.landmark_id for one in found} == wanted
        assert len({one.number for one in found}) == len(wanted)
        if view in ("anterior", "posterior"):  # who faces us has the left at our right
            sign = 1.0 if view == "anterior" else -1.0
            for one in found:
                side = one.landmark.landmark_id.split("_")[0]
                expected = {"left": sign, "right": -sign}.get(side, 0.0)
                assert np.sign(round(one.right_m, 3)) == expected, one.landmark.landmark_id
        if view == "right_lateral" and "c7" in wanted:  # who shows the right side looks right
            places = {one.landmark.landmark_id: one.right_m for one in found}
            assert places["c7"] < places["right_tragus"]


def test_numbers_of_a_figure_move_apart_no_farther_than_they_must():
    assert spread([0.0, 1.0, 2.0], 0.5) == [0.0, 1.0, 2.0]
    assert spread([1.0, 1.0], 0.5) == [0.75, 1.25]
    moved = spread([0.0, 0.1, 0.2, 5.0], 0.3)
    assert np.diff(moved).min() == pytest.approx(0.3)
    assert np.mean(moved[:3]) == pytest.approx(0.1)
    assert moved[3] == 5.0


def test_every_screen_has_its_page():
    assert set(PAGES) == {path.stem for path in resource_path("help", "en").glob("*.md")}
    assert {f"{page}.md" for page in PAGES.values()} <= set(PAGE_NAMES)


@pytest.mark.parametrize("language", LANGUAGES)
def test_keys_and_troubles_are_those_of_the_windows_help(language):
    keys = help_part("capture", language, "Keys")
    assert keys.startswith("| ")
    assert "F5" in keys
    trouble = help_part("capture", language, "What can go wrong")
    assert trouble.count("- **") == 6
    assert set(WORDS[language]) - set(LANGUAGES) >= {"search", "contents", "figure"}


def test_a_list_begins_after_a_paragraph_as_github_reads_it():
    assert with_list_breaks("text:\n- one\n- two") == "text:\n\n- one\n- two"
    assert with_list_breaks("- one\n  goes on\n- two") == "- one\n  goes on\n- two"
    assert with_list_breaks("```\nx\n- y\n```") == "```\nx\n- y\n```"


def test_a_page_knows_its_language():
    assert section_of("manual/ca/data.md") == "ca"
    assert section_of("manual/developers/index.md") == "developers"
    assert section_of("protocols.md") == "reference"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The manual as `make manual` builds it, and nothing that mkdocs warns of."""
    folder = tmp_path_factory.mktemp("built") / "manual"
    script = (
        "from pathlib import Path\nfrom installers.manual.build import build_manual\n"
        f"build_manual(Path({str(folder)!r}))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False, cwd=ROOT
    )
    assert (done.returncode, "WARNING" in done.stderr) == (0, False), done.stderr
    return folder


def test_no_page_fetches_anything_from_elsewhere(site):
    files = [path for path in site.rglob("*") if path.suffix in (".html", ".css", ".js")]
    assert len(files) > 3 * len(PAGE_NAMES)
    for path in files:
        found = FROM_ELSEWHERE.findall(path.read_text(encoding="utf-8"))
        assert path.suffix == ".js" or not found, path.name
    scripts = {path.name for path in site.glob("*.js")}
    assert scripts >= {"search.js", *(f"search-{language}.js" for language in LANGUAGES)}
    assert "fetch(" not in (site / "search.js").read_text(encoding="utf-8")


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_page_is_built_in_its_language_and_nothing_is_left_to_fill_in(site, language):
    for name in PAGE_NAMES:
        page = (site / "manual" / language / name).with_suffix(".html").read_text(encoding="utf-8")
        assert f'<html lang="{language}">' in page
        assert "{{" not in page
        assert page.count("<h1") == 1
        assert not re.findall(r"<img(?![^>]*alt=\"[^\"]+\")", page), name
    found = (site / f"search-{language}.js").read_text(encoding="utf-8")
    assert found.startswith("manualIndex=[")


@pytest.mark.parametrize("name", PAGE_NAMES)
@pytest.mark.parametrize("language", OTHERS)
def test_a_built_page_shows_as_much_in_every_language(site, language, name):
    """With what is filled in from the window's help and from protocols."""
    english, translated = (article(site, one, name) for one in ("en", language))
    assert PART.findall(translated) == PART.findall(english)
    assert SHOWN.findall(translated) == SHOWN.findall(english)


def article(site, language, name):
    page = (site / "manual" / language / name).with_suffix(".html").read_text(encoding="utf-8")
    return page[page.index("<article>") : page.index("</article>")]


def test_the_manual_is_written_in_every_language_of_the_window():
    assert {path.parent.name for path in MANUAL.glob("*/index.md")} == {*LANGUAGES, "developers"}
    assert set(WORDS) == set(LANGUAGES)


def test_a_protocols_page_has_the_numbers_and_names_of_its_file(site):
    page = (site / "manual" / "es" / "upper-quadrant.html").read_text(encoding="utf-8")
    for one in find_protocol("upper-quadrant").landmarks:
        assert one.name.by_language["es"] in page
    assert "50,6 ± 2,1°" in page  # Lau et al. 2009, as the file has it, with a decimal comma


def test_the_manual_is_small_and_its_letters_can_be_read(site):
    size = sum(path.stat().st_size for path in site.rglob("*") if path.is_file())
    assert size < 6_000_000
    kept = sum(path.stat().st_size for path in MANUAL.rglob("*") if path.is_file())
    assert kept < 4_000_000
    colors = dict(COLOR.findall((site / "manual.css").read_text(encoding="utf-8")))
    for ink, ground, least in (
        ("text", "ground", 7.0),
        ("text", "raised", 7.0),
        ("quiet", "ground", 4.5),
        ("accent", "ground", 4.5),
        ("accent", "raised", 4.5),
        ("on-accent", "accent", 7.0),
        ("text", "mark", 7.0),
    ):
        assert contrast(colors[ink], colors[ground]) >= least, (ink, ground)


def contrast(one, other):
    """Return the ratio of WCAG 2.2, section 1.4.3."""
    lights = []
    for color in (one, other):
        rgb = np.array([int(color[k : k + 2], 16) for k in (1, 3, 5)]) / 255
        linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
        lights.append(linear @ [0.2126, 0.7152, 0.0722])
    return (max(lights) + 0.05) / (min(lights) + 0.05)


def test_the_manual_is_packed_with_the_program():
    makefile = Path(ROOT / "Makefile").read_text(encoding="utf-8")
    assert re.search(r"^installer:.*\bmanual\b", makefile, re.MULTILINE)
    assert re.search(r"^run:.*\bmanual\b", makefile, re.MULTILINE)
