"""`adibas gestures`: learn gestures from examples, find them, and say how well that works."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.cli.console import Console
from adibas.cli.exercise import add_check_arguments
from adibas.cli.gestures_evaluation import evaluation_lines
from adibas.cli.options import add_json, add_out, sentence
from adibas.cli.recording_options import add_rotation
from adibas.texts import decimal_text, message, translate_plural
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.gestures.training import TrainingParams
    from adibas.pipeline.gesture_learning import Trained

SUMMARY = message("learn gestures from examples, and find when they begin and end")
TRAIN = message("learn gestures from a folder of examples")
DETECT = message("find the gestures of a model in a table of joints, or in a recording")
EVALUATE = message("measure on people who were left out of the training")
CHECK = message("compare a patient's exercise with the therapist's, repetition by repetition")
MOST_JOINTS = 3
METHODS = ("likeness", "hmm", "dtw", "weighted-dtw", "gmm-dtw", "table-7.1")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    actions = parser.add_subparsers(metavar=_("ACTION"), required=True)
    train = actions.add_parser("train", help=_(TRAIN), description=sentence(_(TRAIN)))
    _add_folder(train)
    train.add_argument(
        "--test",
        action="store_true",
        help=_("leave examples out in turn, too, and say how many are recognised"),
    )
    add_out(train, "model.json", _("file to write"))
    train.set_defaults(action=_train)
    detect = actions.add_parser("detect", help=_(DETECT), description=sentence(_(DETECT)))
    detect.add_argument(
        "source",
        type=Path,
        metavar=_("RECORDING"),
        help=_("a recording, in which joints are found without markers, or a JOINTS.csv"),
    )
    detect.add_argument(
        "--model",
        type=Path,
        metavar="model.json",
        help=_("what `adibas gestures train` wrote; the shipped one if not given"),
    )
    add_rotation(detect)
    add_out(detect, "events.csv", _("file to write"))
    detect.set_defaults(action=_detect)
    evaluate = actions.add_parser("evaluate", help=_(EVALUATE), description=sentence(_(EVALUATE)))
    _add_folder(evaluate)
    evaluate.add_argument(
        "--test",
        type=Path,
        metavar=_("FOLDER"),
        help=_("train on all of the first folder and test on this one"),
    )
    evaluate.set_defaults(action=_evaluate)
    for action in (train, detect, evaluate):
        add_json(action)
    add_check_arguments(actions.add_parser("check", help=_(CHECK), description=sentence(_(CHECK))))


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Train, detect or evaluate."""
    code: int = arguments.action(arguments, console)
    return code


def _add_folder(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "folder",
        type=Path,
        metavar=_("FOLDER"),
        help=_("with *.joints.csv and one events.csv"),
    )
    parser.add_argument(
        "--method",
        choices=METHODS,
        default=METHODS[0],
        help=_("how gestures are told apart; the first if not given"),
    )
    parser.add_argument(
        "--seed",
        type=int,
        default=0,
        metavar="N",
        help=_("of the choice of examples; 0 if not given"),
    )


def _params(arguments: argparse.Namespace) -> "TrainingParams":
    from adibas.gestures.training import TrainingParams

    return TrainingParams(method=arguments.method, seed=arguments.seed)


def _train(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.files import check_place
    from adibas.gestures.model_file import write_model
    from adibas.pipeline.gesture_work import train_on_folder

    check_place(arguments.out)
    with console.progress(_("Training")) as advance:
        trained = train_on_folder(
            arguments.folder, _params(arguments), advance, is_tested=arguments.test
        )
    for notice in trained.notices:
        console.warn(notice.text)
    write_model(arguments.out, trained.model)
    console.say(
        _("{file}: {gestures}, learned from {examples}.").format(
            file=arguments.out,
            gestures=", ".join(trained.model.labels),
            examples=translate_plural("{n} example", "{n} examples", trained.n_examples).format(
                n=trained.n_examples
            ),
        )
    )
    for line in _said(trained):
        console.say(line)
    console.give(
        {
            "out": str(arguments.out),
            "method": trained.model.method,
            "labels": list(trained.model.labels),
            "provenance": trained.model.provenance,
            "notices": [notice.text for notice in trained.notices],
        }
    )
    return 0


def _said(trained: "Trained") -> list[str]:
    """Return which joints tell each gesture, and how well those left out were recognised."""
    from adibas.data.landmark_texts import landmark_text
    from adibas.gestures.descriptor import DESCRIBED_JOINTS

    lines = []
    for label, row in zip(trained.model.labels, trained.weights, strict=True):
        most = sorted(zip(row, DESCRIBED_JOINTS, strict=True), reverse=True)[:MOST_JOINTS]
        joints = ", ".join(f"{landmark_text(joint)} {100 * share:.0f} %" for share, joint in most)
        lines.append(_("{label} is told by: {joints}").format(label=label, joints=joints))
    if trained.tested is not None:
        lines.append(
            _("Left out in turn: {percent} % recognised, {alarms} false alarms").format(
                percent=decimal_text(100 * trained.tested.accuracy, 1),
                alarms=trained.tested.false_alarms,
            )
        )
    return lines


def _detect(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.files import check_place
    from adibas.gestures.model_file import shipped_gestures
    from adibas.pipeline.found_joints import JointSource
    from adibas.pipeline.gesture_work import detect_in_file
    from adibas.recordings.events_csv import write_events_csv

    check_place(arguments.out)
    source = JointSource(arguments.source, rotation_deg=arguments.rotation)
    model = arguments.model or shipped_gestures()
    with console.progress(_("Looking for gestures")) as advance:
        found = detect_in_file(source, model, advance)
    for notice in found.notices:
        console.warn(notice.text)
    write_events_csv(arguments.out, found.events)
    n_events = len(found.events)
    console.say(
        _("{file}: {gestures} found.").format(
            file=arguments.out,
            gestures=translate_plural("{n} gesture", "{n} gestures", n_events).format(n=n_events),
        )
    )
    console.give(
        {
            "out": str(arguments.out),
            "events": [
                {
                    "label": event.label,
                    "begin_s": event.begin_s,
                    "end_s": event.end_s,
                    "person": event.person,
                    "cost": event.cost,
                }
                for event in found.events
            ],
            "notices": [notice.text for notice in found.notices],
        }
    )
    return 0


def _evaluate(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.pipeline.gesture_work import evaluate_folder, evaluation_document

    params = _params(arguments)
    with console.progress(_("Evaluating")) as advance:
        evaluated = evaluate_folder(arguments.folder, arguments.test, params, advance)
    for notice in evaluated.notices:
        console.warn(notice.text)
    for line in evaluation_lines(evaluated, params):
        console.say(line)
    console.give(evaluation_document(evaluated, params))
    return 0
