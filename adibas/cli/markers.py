"""`adibas markers learn`: the colour of the markers, taught by clicks."""

import argparse
from pathlib import Path

from adibas.cli.console import Console
from adibas.cli.options import add_json, add_out, cluster_count, pixel, positive, sentence
from adibas.texts import message, translate_plural
from adibas.texts import translate as _

LARGE_SHARE = 0.2
"""Of the picture: stickers, even in a close-up, take less."""

SUMMARY = message("learn the colour of the markers from clicked pixels")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    actions = parser.add_subparsers(metavar=_("ACTION"), required=True)
    learn = actions.add_parser("learn", help=_(SUMMARY), description=sentence(_(SUMMARY)))
    learn.add_argument(
        "image", type=Path, metavar=_("IMAGE"), help=_("PNG or JPEG picture, or a recording")
    )
    learn.add_argument(
        "--frame",
        type=int,
        default=0,
        metavar="N",
        help=_("which frame of a recording, counted from 0; the first if not given"),
    )
    learn.add_argument(
        "--seed",
        type=pixel,
        action="append",
        required=True,
        metavar="U,V",
        help=_(
            "a pixel of a marker: column and row, counted from 0 at the top left; may be given "
            "several times"
        ),
    )
    learn.add_argument(
        "--sensitivity",
        type=positive,
        metavar="T",
        help=_("how far (CIELAB distance) a pixel may be from the clicked one; 20 if not given"),
    )
    learn.add_argument(
        "--clusters",
        type=cluster_count,
        metavar="K",
        help=_("number of colour centroids; 3 if not given"),
    )
    add_out(
        learn,
        "colours.json",
        _("file to write; a picture of what was taken goes beside it (colours.preview.png)"),
    )
    add_json(learn)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Learn, save the colours, and write a preview of the pixels that were taken."""
    from adibas.pipeline.learning import LearningRequest, learn_from_file

    request = LearningRequest(
        image=arguments.image,
        frame=arguments.frame,
        seeds=tuple(arguments.seed),
        sensitivity=arguments.sensitivity,
        n_clusters=arguments.clusters,
    )
    learned = learn_from_file(request, arguments.out)
    if learned.taken_share > LARGE_SHARE:
        console.warn(
            _(
                "The clicked regions cover {percent} % of the picture. If that is more than the "
                "markers, click on their middle or give a lower --sensitivity."
            ).format(percent=round(100 * learned.taken_share))
        )
    n_clusters = len(learned.model.centroids_lab)
    console.say(
        _("{file}: {pixels} in {colours}; {preview} shows them.").format(
            file=arguments.out,
            pixels=translate_plural("{n} pixel", "{n} pixels", learned.n_pixels).format(
                n=learned.n_pixels
            ),
            colours=translate_plural("{n} colour", "{n} colours", n_clusters).format(n=n_clusters),
            preview=learned.preview_path,
        )
    )
    console.give(
        {
            "out": str(arguments.out),
            "preview": str(learned.preview_path),
            "n_pixels": learned.n_pixels,
            "centroids_lab": learned.model.centroids_lab.tolist(),
            "threshold": learned.model.threshold,
        }
    )
    return 0
