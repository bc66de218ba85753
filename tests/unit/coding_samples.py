"""Ethograms and codings for tests: one written by hand, and any that Hypothesis thinks of."""

from hypothesis import strategies as st

from adibas.data.coding import Coding, Occurrence, Section
from adibas.data.ethogram import Behaviour, Ethogram, Modifier, Subject

ETHOGRAM = Ethogram(
    "table",
    (
        Behaviour(
            "seated", "state", "on the chair", "s", "place", "#009E73", (), ("up",), ("own",)
        ),
        Behaviour("up", "state", "", "u", "place"),
        Behaviour(
            "fidgets",
            modifiers=(Modifier("with", ("pen", "hair"), "several"), Modifier("side", ("left",))),
        ),
        Behaviour("nods", "point", modifiers=(Modifier("times", (), "number"),)),
    ),
    (Subject("child", "1", "observed"), Subject("peer", "2")),
    "for tests",
    ("nobody",),
    is_locked=True,
)


def coding(*occurrences, end_ms=60_000, observer="AB", **more):
    """Return a coding of a minute; each occurrence as (behaviour, begin s, end s, subject)."""
    found = tuple(
        Occurrence(name, round(1000 * begin), round(1000 * end), *rest)
        for name, begin, end, *rest in occurrences
    )
    return Coding("session 1", ETHOGRAM, 0, end_ms, found, observer, **more)


texts = st.text(
    st.characters(
        min_codepoint=32,
        max_codepoint=0x2FFF,
        exclude_characters="\x7f\x85",
        exclude_categories=("C", "Z"),
    )
    | st.just(" "),
    max_size=8,
)
names = texts.map(str.strip).filter(bool)
END_MS = 30_000


@st.composite
def states(draw, behaviour, subject, modifiers):
    """Draw states of one behaviour that do not overlap; they may touch, and may last no time."""
    bounds = sorted(draw(st.lists(st.integers(0, END_MS), max_size=6)))
    return [
        Occurrence(behaviour, begin, end, subject, draw(modifiers), draw(texts), draw(texts))
        for begin, end in zip(bounds[::2], bounds[1::2], strict=False)
    ]


@st.composite
def codings(draw, observer="AB"):
    """Draw a coding by `ETHOGRAM`."""
    found = []
    for subject in ("", "child", "peer"):
        place = draw(st.sampled_from(["seated", "up"]))
        found += draw(states(place, subject, st.just(())))
        found += draw(
            states(
                "fidgets",
                subject,
                st.sampled_from([(), ("pen",), ("pen,hair",), ("", "left"), ("hair", "left")]),
            )
        )
        points = draw(st.lists(st.integers(0, END_MS), max_size=4, unique=True))
        found += [
            Occurrence(
                "nods", at, at, subject, draw(st.sampled_from([(), ("2",), ("0.5",)])), draw(texts)
            )
            for at in points
        ]
    bounds = sorted(draw(st.lists(st.integers(0, END_MS), max_size=4, unique=True)))
    sections = [
        Section(draw(st.sampled_from(["game", "task"])), begin, end)
        for begin, end in zip(bounds[::2], bounds[1::2], strict=False)
    ]
    return Coding(
        draw(names),
        ETHOGRAM,
        0,
        END_MS,
        tuple(found),
        observer,
        tuple(sections),
        draw(texts),
        "2026-11-21T10:00:00",
        ("child.mcap",),
        (("age", draw(texts)),),
    )
