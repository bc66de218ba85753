"""`adibas skeleton`: names for markers that have none, and the models that know them."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.cli.console import Console
from adibas.cli.options import add_json, add_out, positive, positive_count, sentence
from adibas.cli.store_options import add_store, open_existing
from adibas.data.posture import VIEWS
from adibas.errors import FileError
from adibas.files import check_place
from adibas.texts import message, translate_plural
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.skeleton.model import SkeletonModel

SUMMARY = message("give markers their names, and learn how named markers lie")
TRAIN = message("learn a model from labelled point sets")
LABEL = message("name the points of a file")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    actions = parser.add_subparsers(metavar=_("ACTION"), required=True)
    _add_train(actions.add_parser("train", help=_(TRAIN), description=sentence(_(TRAIN))))
    _add_label(actions.add_parser("label", help=_(LABEL), description=sentence(_(LABEL))))


def _add_train(train: argparse.ArgumentParser) -> None:
    train.add_argument(
        "shapes",
        type=Path,
        nargs="?",
        metavar="shapes.csv",
        help=_("shape,point,label,x_m,y_m[,z_m]: a row each point, y down"),
    )
    train.add_argument(
        "--simulator",
        action="store_true",
        help=_("learn the 15 joints from simulated people in place of a file"),
    )
    train.add_argument(
        "--bodies",
        type=positive_count,
        metavar="N",
        help=_("how many people are simulated; as many as of the shipped model if not given"),
    )
    train.add_argument(
        "--poses",
        type=positive_count,
        metavar="N",
        help=_("how many poses of each; as many as of the shipped model if not given"),
    )
    train.add_argument(
        "--seed",
        type=int,
        metavar="N",
        help=_("start of the random numbers; that of the shipped model if not given"),
    )
    train.add_argument(
        "--sessions",
        action="store_true",
        help=_("learn from the captures of the patient store whose markers were corrected"),
    )
    train.add_argument(
        "--protocol",
        metavar=_("NAME"),
        help=_("with --sessions: from those of this protocol alone"),
    )
    train.add_argument(
        "--view",
        choices=VIEWS,
        default="",
        help=_("with --sessions: the view, where the protocol marks other places in each"),
    )
    train.add_argument(
        "--use",
        action="store_true",
        help=_("name the markers of this user by the model from now on, where a protocol fits"),
    )
    add_out(train, "model.json", _("model to write; an older one is replaced"))
    add_store(train)
    train.set_defaults(action=_train)


def _add_label(label: argparse.ArgumentParser) -> None:
    label.add_argument(
        "points",
        type=Path,
        metavar="points.csv",
        help=_("shape,point,label,x_m,y_m[,z_m]: label is empty where it is to be found"),
    )
    label.add_argument(
        "--model",
        type=Path,
        metavar="model.json",
        help=_("what skeleton train has written; the 15 joints if not given"),
    )
    label.add_argument(
        "--view",
        choices=VIEWS,
        default="",
        help=_("which side is seen; without it left and right are named only where they show"),
    )
    label.add_argument(
        "--movement",
        type=positive,
        metavar="HZ",
        help=_("the shapes are frames of one movement, so many a second: names are followed"),
    )
    label.add_argument(
        "--still",
        action="store_true",
        help=_("the people hold still, as in a capture: how they may stand is known better"),
    )
    label.add_argument(
        "--posture",
        action="store_true",
        help=_("say of each shape which posture of the training it looks like"),
    )
    add_out(label, "labelled.csv", _("file to write; an older one is replaced"))
    add_json(label)
    label.set_defaults(action=_label)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Train or label."""
    check_place(arguments.out)
    code: int = arguments.action(arguments, console)
    return code


def _learned(arguments: argparse.Namespace, console: Console) -> "SkeletonModel":
    from adibas.pipeline.skeleton_training import (
        PROTOTYPE_PEOPLE,
        train_from_file,
        train_from_simulator,
    )

    if arguments.simulator:
        given = {"n_bodies": arguments.bodies, "n_poses": arguments.poses, "seed": arguments.seed}
        known = {key: value for key, value in given.items() if value is not None}
        people = replace(PROTOTYPE_PEOPLE, **known)
        console.say(_("Seed {seed}").format(seed=people.seed))
        with console.progress(_("Simulating people")) as progress:
            return train_from_simulator(people, progress)
    if arguments.sessions:
        return _learned_from_sessions(arguments, console)
    return train_from_file(arguments.shapes)


def _learned_from_sessions(arguments: argparse.Namespace, console: Console) -> "SkeletonModel":
    from adibas.pipeline.skeleton_examples import landmark_set
    from adibas.pipeline.skeleton_sessions import train_from_sessions

    which = None
    if arguments.protocol is not None:
        which = landmark_set(arguments.protocol, arguments.view)
    with open_existing(arguments) as store, console.progress(_("Reading sessions")) as progress:
        model, held_out = train_from_sessions(store, progress, which)
    console.say(
        _(
            "Of {n} captures not learned from, {right} are named right, {wrong} with a mistake."
        ).format(n=held_out.n_examples, right=held_out.right, wrong=held_out.wrong)
    )
    held_out.check()
    return model


def _train(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.pipeline.namers import keep_own_model
    from adibas.skeleton.model_files import write_model

    sources = (arguments.simulator, arguments.sessions, arguments.shapes is not None)
    if sum(sources) != 1:
        raise FileError("Give a file of labelled shapes, --simulator or --sessions: one of them.")
    if (arguments.protocol or arguments.view) and not arguments.sessions:
        raise FileError("--protocol and --view choose among sessions. Give --sessions, too.")
    model = _learned(arguments, console)
    write_model(model, arguments.out)
    if arguments.use:
        keep_own_model(model)
    n_prototypes = sum(len(part.prototypes) for part in model.models())
    console.say(
        _("{file}: {names}, {prototypes}.").format(
            file=arguments.out,
            names=translate_plural("{n} name", "{n} names", len(model.names)).format(
                n=len(model.names)
            ),
            prototypes=translate_plural("{n} prototype", "{n} prototypes", n_prototypes).format(
                n=n_prototypes
            ),
        )
    )
    console.give(
        {
            "out": str(arguments.out),
            "names": list(model.names),
            "n_prototypes": n_prototypes,
            "provenance": dict(model.provenance),
        }
    )
    return 0


def _label(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.pipeline.skeleton_labelling import LabelRequest, label_file

    if arguments.posture and arguments.movement:
        raise FileError("--posture is said of single shapes. Leave out --movement.")
    if arguments.still and arguments.movement:
        raise FileError("Somebody who moves does not hold still. Leave out --still or --movement.")
    request = LabelRequest(
        arguments.points,
        arguments.model,
        arguments.view,
        arguments.movement,
        holds_still=arguments.still,
        with_posture=arguments.posture,
    )
    with console.progress(_("Naming")) as progress:
        found = label_file(request, arguments.out, progress)
    console.say(
        _("{file}: {n_named} of {n_points} points have names, {n_unsure} are not sure.").format(
            file=arguments.out,
            n_named=found.n_named,
            n_points=found.n_points,
            n_unsure=found.n_unsure,
        )
    )
    console.give(
        {
            "out": str(arguments.out),
            "n_shapes": found.n_shapes,
            "n_points": found.n_points,
            "n_named": found.n_named,
            "n_unsure": found.n_unsure,
        }
    )
    return 0
