"""`adibas limbs`: train a model of limbs, find limbs in a recording, say how well that works."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.cli.console import Console
from adibas.cli.interrupts import kept_when_stopped
from adibas.cli.limbs_evaluation import evaluation_document, evaluation_lines
from adibas.cli.options import add_json, add_out, positive, positive_count, sentence
from adibas.cli.recording_options import (
    add_calibration,
    add_frames,
    add_recording,
    add_rotation,
)
from adibas.texts import message, translate_plural
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.limbs.model import LimbModel
    from adibas.limbs.segmentation import LimbParams

SUMMARY = message("find the limbs of a person in the depth image, without markers")
TRAIN = message("learn limbs from labelled depth images, or from simulated people")
SEGMENT = message("find the limbs in every frame of a recording")
PROPOSE = message("label the limbs in a recording by its joints, to be corrected in the window")
EVALUATE = message("measure on labelled images that had no part in the training")
SETS = ("full-body-15", "upper-body-7", "hand-6")
CUTS = ("omega_1", "omega_2", "none")
N_FRAMES = 16_000
SHIPPED_FOREST, THESIS_FOREST = (3, 24, 1200), (3, 20, 1000)
"""Trees, depth, pixels of an image."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    actions = parser.add_subparsers(metavar=_("ACTION"), required=True)
    train = actions.add_parser("train", help=_(TRAIN), description=sentence(_(TRAIN)))
    _add_train(train)
    segment = actions.add_parser("segment", help=_(SEGMENT), description=sentence(_(SEGMENT)))
    _add_segment(segment)
    propose = actions.add_parser("propose", help=_(PROPOSE), description=sentence(_(PROPOSE)))
    _add_propose(propose)
    evaluate = actions.add_parser("evaluate", help=_(EVALUATE), description=sentence(_(EVALUATE)))
    _add_evaluate(evaluate)
    for action in (train, segment, propose, evaluate):
        add_json(action)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Train, segment, propose or evaluate."""
    code: int = arguments.action(arguments, console)
    return code


def _add_train(parser: argparse.ArgumentParser) -> None:
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument(
        "folders",
        type=Path,
        nargs="*",
        default=[],
        metavar=_("FOLDER"),
        help=_(
            "with NNNN.depth.png, NNNN.labels.png and labels.json; several are learned together"
        ),
    )
    source.add_argument(
        "--simulator", action="store_true", help=_("learn from simulated people instead")
    )
    source.add_argument(
        "--merge",
        type=Path,
        metavar="model.npz",
        help=_("make a model of the seven labels out of one of the fifteen, without training"),
    )
    how = parser.add_mutually_exclusive_group()
    how.add_argument(
        "--context",
        type=Path,
        metavar="model.npz",
        help=_(
            "keep the forest of this model, and learn on images that it has not seen to correct it "
            "by what is around; what it has learned of that before is kept and goes on"
        ),
    )
    how.add_argument(
        "--cluster",
        default="",
        metavar=_("ADDRESS"),
        help=_("train on the Dask cluster whose scheduler is there, such as tcp://10.0.0.7:8786"),
    )
    parser.add_argument(
        "--labels", choices=SETS, default="", help=_("those of the images if not given")
    )
    _add_count(parser, "--frames", N_FRAMES, _("how many images are simulated; {n} if not given"))
    _add_forest(parser, SHIPPED_FOREST)
    add_out(parser, "model.npz", _("model to write; an older one is replaced"))
    parser.set_defaults(action=_train, refuse=parser.error)


def _add_forest(parser: argparse.ArgumentParser, forest: tuple[int, int, int]) -> None:
    n_trees, depth, n_pixels = forest
    _add_count(parser, "--trees", n_trees, _("of the forest; {n} if not given"))
    _add_count(parser, "--depth", depth, _("of each tree; {n} if not given"))
    _add_count(parser, "--pixels", n_pixels, _("drawn from each image; {n} if not given"))
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help=_("of what is random; 0 if not given")
    )


def _add_count(parser: argparse.ArgumentParser, name: str, default: int, text: str) -> None:
    parser.add_argument(
        name, type=positive_count, default=default, metavar="N", help=text.format(n=default)
    )


def _add_cut(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--cut",
        choices=CUTS,
        default=CUTS[0],
        help=_("prices of neighbouring labels in the graph cut; the first if not given"),
    )
    parser.add_argument(
        "--smoothness",
        type=positive,
        default=1.0,
        metavar="N",
        help=_("lambda of the graph cut; 1 if not given"),
    )


def _add_segment(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "recording",
        type=Path,
        metavar=_("RECORDING"),
        help=_(".mcap, .oni or a TUM RGB-D folder with depth"),
    )
    parser.add_argument(
        "--model",
        type=Path,
        metavar="model.npz",
        help=_("what limbs train has written; the shipped one if not given"),
    )
    parser.add_argument(
        "--labels",
        choices=SETS[:2],
        default="",
        help=_("of the shipped model; all 15 if not given"),
    )
    add_calibration(parser)
    add_rotation(parser)
    add_frames(parser, _("frames to look at; all if not given"))
    _add_cut(parser)
    parser.add_argument(
        "--over-time",
        type=positive,
        default=0.0,
        metavar="N",
        help=_("lambda of ties between a pixel and itself one frame before; 0, none, if not given"),
    )
    parser.add_argument(
        "--behind", action="store_true", help=_("the person turns the back to the camera")
    )
    add_out(
        parser,
        _("FOLDER"),
        _("folder for the pictures and labels; frames with labels stay as they are"),
    )
    parser.set_defaults(action=_segment, refuse=parser.error)


def _add_propose(parser: argparse.ArgumentParser) -> None:
    add_recording(parser)
    add_calibration(parser)
    add_rotation(parser)
    add_frames(parser, _("frames to label; all if not given"))
    parser.add_argument(
        "--labels", choices=SETS[:2], default=SETS[0], help=_("all 15 if not given")
    )
    parser.add_argument(
        "--done",
        action="store_true",
        help=_("take the proposals as they are: limbs train reads them at once"),
    )
    add_out(parser, _("FOLDER"), _("folder for the labels; frames with labels stay as they are"))
    parser.set_defaults(action=_propose)


def _add_evaluate(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "folders",
        type=Path,
        nargs="+",
        metavar=_("FOLDER"),
        help=_("of labelled depth images; several are one set"),
    )
    measured = parser.add_mutually_exclusive_group()
    measured.add_argument(
        "--model",
        type=Path,
        metavar="model.npz",
        help=_("measure this model; without it models are trained on parts of the folder"),
    )
    measured.add_argument(
        "--shipped",
        action="store_const",
        dest="model",
        const="shipped",
        help=_("measure the model that comes with the program"),
    )
    parser.add_argument(
        "--leave-out",
        choices=("folds", "people"),
        default="folds",
        help=_("a fifth of the images at a time, or one person; the first if not given"),
    )
    parser.add_argument(
        "--pictures",
        type=Path,
        metavar=_("FOLDER"),
        help=_("folder for a picture of each image: the truth, and what each step makes of it"),
    )
    _add_forest(parser, THESIS_FOREST)
    _add_cut(parser)
    parser.set_defaults(action=_evaluate)


def _limb_params(arguments: argparse.Namespace, step: int) -> "LimbParams":
    from adibas.limbs.segmentation import LimbParams

    return LimbParams(
        arguments.cut,
        arguments.smoothness,
        over_time=getattr(arguments, "over_time", 0.0),
        step=step,
        is_from_behind=getattr(arguments, "behind", False),
    )


def _train(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.files import check_place
    from adibas.pipeline.limb_training import merge_model
    from adibas.pipeline.unfinished_training import work_folder

    if arguments.merge is not None and (arguments.context or arguments.cluster):
        arguments.refuse(_("--merge trains nothing: leave --context and --cluster out"))
    check_place(arguments.out)
    with kept_when_stopped(work_folder(arguments.out)):
        if arguments.merge is not None:
            model = merge_model(arguments.merge, arguments.out)
        elif arguments.context is not None:
            model = _train_context(arguments, console)
        else:
            model = _train_forest(arguments, console)
    console.say(
        _("{file}: {labels}, {trees}.").format(
            file=arguments.out,
            labels=translate_plural("{n} label", "{n} labels", len(model.labels)).format(
                n=len(model.labels)
            ),
            trees=translate_plural("{n} tree", "{n} trees", model.forest.n_trees).format(
                n=model.forest.n_trees
            ),
        )
    )
    console.give(
        {
            "out": str(arguments.out),
            "label_set": model.labels.name,
            "labels": list(model.labels.names),
            "provenance": dict(model.forest.provenance),
        }
    )
    return 0


def _train_forest(arguments: argparse.Namespace, console: Console) -> "LimbModel":
    from adibas.pipeline.limb_training import SHIPPED, TrainingRequest, train_model

    params = replace(
        SHIPPED, n_trees=arguments.trees, max_depth=arguments.depth, n_pixels=arguments.pixels
    )
    request = TrainingRequest(
        arguments.out,
        tuple(arguments.folders),
        arguments.labels,
        arguments.frames,
        arguments.seed,
        params,
        arguments.cluster,
    )
    with (
        console.progress(_("Simulating people")) as simulating,
        console.progress(_("Training")) as training,
    ):
        bars = {"simulating": simulating, "training": training}
        return train_model(request, lambda step, done, total: bars[step](done, total))


def _train_context(arguments: argparse.Namespace, console: Console) -> "LimbModel":
    from adibas.pipeline.context_training import ContextRequest, train_context_of

    request = ContextRequest(
        arguments.context,
        arguments.out,
        tuple(arguments.folders),
        arguments.frames,
        arguments.seed,
    )
    with (
        console.progress(_("Simulating people")) as simulating,
        console.progress(_("Asking the forest")) as looking,
        console.progress(_("Training")) as training,
    ):
        bars = {"simulating": simulating, "looking": looking, "training": training}
        return train_context_of(request, lambda step, done, total: bars[step](done, total))


def _segment(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.pipeline.limb_segmenting import SegmentingRequest, segment_recording

    if arguments.over_time and arguments.cut == "none":
        arguments.refuse(_("--over-time ties pixels in the cut: leave --cut none out"))
    request = SegmentingRequest(
        arguments.recording,
        arguments.out,
        arguments.model,
        arguments.labels,
        arguments.calibration,
        arguments.frames,
        _limb_params(arguments, step=2),
        arguments.rotation,
    )
    with console.progress(_("Segmenting")) as progress:
        done = segment_recording(request, progress)
    for notice, n_frames in done.notices:
        told = translate_plural("{n} frame", "{n} frames", n_frames).format(n=n_frames)
        console.warn(f"{told}: {notice.text}")
    console.say(
        _("{folder}: limbs in {n_people} of {n_frames} frames.").format(
            folder=arguments.out, n_people=done.n_people, n_frames=done.n_frames
        )
    )
    if done.n_known:
        console.say(
            translate_plural(
                "{n} frame was labelled before and stays as it is. Choose another folder to have "
                "it segmented.",
                "{n} frames were labelled before and stay as they are. Choose another folder to "
                "have them segmented.",
                done.n_known,
            ).format(n=done.n_known)
        )
    console.give(
        {
            "out": str(arguments.out),
            "n_frames": done.n_frames,
            "n_with_person": done.n_people,
            "n_labelled_before": done.n_known,
            "notices": [
                {"text": notice.text, "n_frames": n_frames} for notice, n_frames in done.notices
            ],
        }
    )
    return 0


def _propose(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.pipeline.limb_proposing import ProposingRequest, propose_recording

    request = ProposingRequest(
        arguments.recording,
        arguments.out,
        arguments.labels,
        arguments.calibration,
        arguments.frames,
        is_done=arguments.done,
        rotation_deg=arguments.rotation,
    )
    with console.progress(_("Looking for limbs")) as progress:
        found = propose_recording(request, progress)
    for text, n_frames in found.notices:
        told = translate_plural("{n} frame", "{n} frames", n_frames).format(n=n_frames)
        console.warn(f"{told}: {text}")
    console.say(
        _("{folder}: frames with proposed limbs: {n_proposed}, labelled before: {n_known}.").format(
            folder=arguments.out, n_proposed=found.n_proposed, n_known=found.n_known
        )
    )
    console.give(
        {
            "out": str(arguments.out),
            "n_frames": found.n_frames,
            "n_labelled_before": found.n_known,
            "n_proposed": found.n_proposed,
            "notices": [{"text": text, "n_frames": n} for text, n in found.notices],
        }
    )
    return 0


def _evaluate(arguments: argparse.Namespace, console: Console) -> int:
    from adibas.forests.params import ForestParams
    from adibas.pipeline.limb_evaluation import EvaluationParams, evaluate_folders

    params = EvaluationParams(
        arguments.leave_out,
        arguments.seed,
        ForestParams(
            n_trees=arguments.trees,
            max_depth=arguments.depth,
            n_pixels=arguments.pixels,
            n_images=None,
        ),
        _limb_params(arguments, step=1),
    )
    with console.progress(_("Evaluating")) as progress:
        result = evaluate_folders(
            arguments.folders, arguments.model, params, arguments.pictures, progress
        )
    for line in evaluation_lines(result):
        console.say(line)
    console.give(evaluation_document(result))
    return 0
