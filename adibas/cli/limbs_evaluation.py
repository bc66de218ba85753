"""What `adibas limbs evaluate` prints: how often each label is right, after each step."""

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from adibas.texts import SpokenNumber
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.limbs.evaluation import Confusion
    from adibas.pipeline.limb_evaluation import LimbEvaluation


def evaluation_lines(result: "LimbEvaluation") -> list[str]:
    """Return the lines: the mean over labels, each label, which the cut worsens, the confusion."""
    lines = [_protocol_line(result), _mean_line(result)]
    labels = result.forest.labels
    width = max(map(len, labels))
    steps = [one for one in (result.forest, result.network, result.cut) if one is not None]
    for label, *shares in zip(labels, *(one.per_class for one in steps), strict=True):
        columns = "  ".join(map(_percent, shares))
        lines.append(f"{label:{width}}  {columns}".rstrip())
    before, after = result.before_cut.per_class, result.cut.per_class
    worse = [label for label, one, other in zip(labels, before, after, strict=True) if other < one]
    if worse:
        lines.append(_("The cut makes these labels worse: {labels}.").format(
            labels=", ".join(worse)
        ))  # fmt: skip
    else:
        lines.append(_("The cut makes no label worse."))
    return [*lines, *_confusion_lines(result.cut)]


def _confusion_lines(cut: "Confusion") -> Iterator[str]:
    """Yield the confusion after the cut, a label a line: percent of what it was taken for."""
    yield _("What the pixels of each label were taken for after the cut, in % (0 is left empty):")
    width = max(map(len, cut.labels))
    numbers = range(1, len(cut.labels) + 1)
    yield " " * (width + 4) + "".join(f"{number:4}" for number in numbers)
    for number, label, counts in zip(numbers, cut.labels, cut.counts, strict=True):
        percent = (100 * counts / max(int(counts.sum()), 1)).round().astype(int).tolist()
        cells = "".join(f"{one or '':>4}" for one in percent)
        yield f"{number:2}  {label:{width}}{cells}".rstrip()


def _protocol_line(result: "LimbEvaluation") -> str:
    if result.n_groups == 1:
        return _("One model, {images} images").format(images=result.n_images)
    return _("{protocol}, {n} groups, {images} images").format(
        protocol=result.protocol, n=result.n_groups, images=result.n_images
    )


def _percent(share: float) -> str:
    """Return a column; a dash for a label that no pixel has."""
    return f"{'-':>6}  " if math.isnan(share) else f"{SpokenNumber(100 * share):6.1f} %"


def _mean_line(result: "LimbEvaluation") -> str:
    forest = SpokenNumber(100 * result.forest.mean_per_class)
    cut = SpokenNumber(100 * result.cut.mean_per_class)
    if result.network is None:
        told = _("Mean per label: forest {forest:.1f} %, with graph cut {cut:.1f} %")
        return told.format(forest=forest, cut=cut)
    told = _(
        "Mean per label: forest {forest:.1f} %, with its network {network:.1f} %, and with graph "
        "cut {cut:.1f} %"
    )
    network = SpokenNumber(100 * result.network.mean_per_class)
    return told.format(forest=forest, network=network, cut=cut)


def evaluation_document(result: "LimbEvaluation") -> dict[str, object]:
    """Return plain values of the same, with the confusions."""
    return {
        "protocol": result.protocol,
        "n_groups": result.n_groups,
        "n_images": result.n_images,
        "labels": list(result.forest.labels),
        "forest": _figures(result.forest),
        "network": None if result.network is None else _figures(result.network),
        "cut": _figures(result.cut),
    }


def _figures(confusion: "Confusion") -> Mapping[str, object]:
    """Return plain values; None where a label never occurs."""
    return {
        "mean_per_class": _finite(confusion.mean_per_class),
        "overall": _finite(confusion.overall),
        "per_class": {
            label: _finite(float(share))
            for label, share in zip(confusion.labels, confusion.per_class, strict=True)
        },
        "confusion": confusion.counts.tolist(),
    }


def _finite(share: float) -> float | None:
    return None if math.isnan(share) else share
