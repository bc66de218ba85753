"""What mkdocs does besides turning Markdown into pages: languages, protocols, keys, and search.

A page may hold lines of its own, which are filled in here and so never copied by hand:
``{{ protocol ID }}`` (figures, landmarks and measures of a protocol), ``{{ keys SCREEN }}`` and
``{{ trouble SCREEN }}`` (those parts of the window's help), ``{{ file NAME }}`` (an example).
"""

import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.nav import Navigation, Section
from mkdocs.structure.pages import Page

from adibas import __version__
from adibas.resources import resource_path
from adibas.texts import LANGUAGES, speaking
from installers.manual.protocol_pages import protocol_part
from installers.manual.words import WORDS

DEVELOPERS, REFERENCE = "developers", "reference"
SECTION_OF = {"manual/developers/": DEVELOPERS} | {f"manual/{one}/": one for one in LANGUAGES}
FILLED = re.compile(r"^\{\{ (\w+) ([\w./-]+) \}\}$", re.MULTILINE)
LIST_ITEM = re.compile(r"(- |\d+\. )")
SECTION = re.compile(r"<h[23] id=\"([^\"]+)\">(.*?)</h[23]>")
TAG = re.compile(r"<[^>]+>")

_found: dict[str, list[dict[str, str]]] = {}
"""What can be searched, by section; mkdocs gives a hook no other place."""


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Add the developers' documents, which stand in no list of their own."""
    _found.clear()
    names = sorted(path.name for path in Path(config.docs_dir).glob("*.md"))
    reference = [name for name in names if name != "index.md"]
    config.nav = [{"home": "index.md"}, *(config.nav or []), {REFERENCE: reference}]
    return config


def section_of(path: str) -> str:
    """Return to which part of the manual a file belongs: a language, or the developers'."""
    starts = (name for start, name in SECTION_OF.items() if path.startswith(start))
    return next(starts, REFERENCE)


def on_page_markdown(markdown: str, page: Page, **_mkdocs: Any) -> str:
    """Fill in what stands elsewhere; lists begin without an empty line, as GitHub reads them."""
    section = section_of(page.file.src_uri)
    language = section if section in LANGUAGES else "en"
    folder = Path(str(page.file.abs_src_path)).parent

    def filled(match: re.Match[str]) -> str:
        kind, name = match.groups()
        with speaking(language):
            return FILL[kind](name, language, folder)

    return with_list_breaks(FILLED.sub(filled, markdown))


def with_list_breaks(markdown: str) -> str:
    """Put an empty line before each list that follows a paragraph."""
    lines: list[str] = []
    is_code = False
    for line in markdown.splitlines():
        before = lines[-1] if lines else ""
        is_code ^= line.lstrip().startswith("```")
        begins = LIST_ITEM.match(line) and before and not before.startswith((" ", "#", "|"))
        if begins and not is_code and not LIST_ITEM.match(before):
            lines.append("")
        lines.append(line)
    return "\n".join(lines)


def _protocol(name: str, language: str, _folder: Path) -> str:
    return protocol_part(name, language)


def _keys(name: str, language: str, _folder: Path) -> str:
    return help_part(name, language, "Keys")


def _trouble(name: str, language: str, _folder: Path) -> str:
    return help_part(name, language, "What can go wrong")


def _file(name: str, _language: str, folder: Path) -> str:
    kind = {".py": "python", ".json": "json"}[Path(name).suffix]
    return f"```{kind}\n{(folder / name).read_text('utf-8').rstrip()}\n```"


FILL: Mapping[str, Callable[[str, str, Path], str]] = {
    "protocol": _protocol,
    "keys": _keys,
    "trouble": _trouble,
    "file": _file,
}


def help_part(screen: str, language: str, title: str) -> str:
    """Return a part of a screen's help by its English title; other languages have it there, too."""
    titles = [one for one, _text in _help_parts(screen, "en")]
    return _help_parts(screen, language)[titles.index(title)][1]


def _help_parts(screen: str, language: str) -> list[tuple[str, str]]:
    page = resource_path("help", language, f"{screen}.md").read_text("utf-8")
    parts = [part.partition("\n") for part in re.split(r"^## ", page, flags=re.MULTILINE)[1:]]
    return [(title.strip(), text.strip()) for title, _newline, text in parts]


def on_page_content(html: str, page: Page, **_mkdocs: Any) -> str:
    """Note what can be searched on the page; what is wide scrolls by itself, also by keys."""
    entries = _found.setdefault(section_of(page.file.src_uri), [])
    title, start = str(page.title), 0
    heads = [*SECTION.finditer(html), None]
    name, anchor = title, ""
    for head in heads:
        text = TAG.sub(" ", html[start : head.start() if head else len(html)])
        entries.append({"u": page.url + anchor, "p": title, "t": name, "x": " ".join(text.split())})
        if head:
            name, anchor, start = TAG.sub("", head.group(2)), f"#{head.group(1)}", head.end()
    html = html.replace("<table>", '<div class="wide" tabindex="0"><table>')
    return html.replace("</table>", "</table></div>").replace("<pre>", '<pre tabindex="0">')


def on_page_context(
    context: dict[str, Any], page: Page, nav: Navigation, **_mkdocs: Any
) -> dict[str, Any]:
    """Give the page the contents of its language, its neighbours, and itself in others."""
    section = section_of(page.file.src_uri)
    language = section if section in LANGUAGES else "en"
    shown = (section,) if section in LANGUAGES else (DEVELOPERS, REFERENCE)
    parts = {item.title: item for item in nav.items if isinstance(item, Section)}
    pages = [one for name in shown for one in (parts[name].children or [])]
    place = pages.index(page) if page in pages else -1
    return context | {
        "section": section,
        "language": language,
        "languages": LANGUAGES,
        "words": WORDS[language],
        "parts": [(WORDS[language][name], parts[name].children) for name in shown],
        "before": pages[place - 1] if place > 0 else None,
        "after": pages[place + 1] if 0 <= place < len(pages) - 1 else None,
        "is_translated": section in LANGUAGES,
        "name": page.file.name,
        "version": __version__,
    }


def on_post_build(config: MkDocsConfig) -> None:
    """Write what can be searched as scripts: a page from the disk may not read other files."""
    site = Path(config.site_dir)
    for section, entries in _found.items():
        text = json.dumps(entries, ensure_ascii=False, separators=(",", ":"))
        (site / f"search-{section}.js").write_text(f"manualIndex={text}\n", encoding="utf-8")
    for name in ("sitemap.xml", "sitemap.xml.gz"):
        (site / name).unlink(missing_ok=True)
