"""`adibas pose`: a recording in, fifteen joints of everybody in it out, without markers."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.cli.console import Console
from adibas.cli.options import add_json
from adibas.cli.recording_options import (
    add_calibration,
    add_frames,
    add_person,
    add_recording,
    add_rotation,
    add_shown_view,
)
from adibas.errors import FileError, RecordingError
from adibas.files import check_place
from adibas.texts import message, translate_plural
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.pipeline.pose import PosedRecording

SUMMARY = message("find the joints of everybody in a recording without markers")

KINDS_OF_ONE = (".trc", ".c3d")
"""They hold one person."""
POSE_KINDS = (".csv", *KINDS_OF_ONE)
LAGS = range(11)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    add_recording(parser)
    parser.add_argument(
        "--model",
        type=Path,
        metavar="model.npz",
        help=_("of the limbs of the full body; the program's own if not given"),
    )
    add_calibration(parser)
    add_rotation(parser)
    add_shown_view(parser)
    add_frames(parser, _("frames to look at, B not included; all of them if not given"))
    add_person(
        parser,
        _("for TRC and C3D, which hold one person; the one who was seen longest if not given"),
    )
    parser.add_argument(
        "--lag",
        type=int,
        choices=LAGS,
        default=2,
        metavar="N",
        help=_("later frames that smoothing waits for, 0 to 10; 2 if not given"),
    )
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        action="append",
        metavar="joints.csv|.trc|.c3d",
        help=_("file to write; may be given several times"),
    )
    add_json(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Find the joints and write the files."""
    from adibas.pipeline.pose import PoseRequest, pose_recording
    from adibas.pipeline.pose_following import PoseParams
    from adibas.reports.pose_files import pose_to_json, write_pose
    from adibas.skeleton.smoothing import SmoothingParams

    for path in arguments.out:
        if path.suffix.lower() not in POSE_KINDS:
            raise FileError(
                "{file} is no file of joints. Give --out a name that ends in one of: {endings}.",
                file=path.name or str(path),
                endings=", ".join(POSE_KINDS),
            )
        check_place(path)
    request = PoseRequest(
        arguments.recording,
        arguments.model,
        arguments.calibration,
        arguments.frames,
        PoseParams(view=arguments.view),
        SmoothingParams(lag_frames=arguments.lag),
        rotation_deg=arguments.rotation,
    )
    with console.progress(_("Looking for joints")) as progress:
        posed = pose_recording(request, progress)
    person = _person(arguments.person, posed)
    for path in arguments.out:
        write_pose(posed, path, person)
    for notice in posed.notices:
        console.warn(notice.text)
    _tell(posed, arguments.out, person, console)
    if not arguments.view:
        _tell_sides(posed, console)
    console.give(pose_to_json(posed, arguments.out))
    return 0


def _person(wanted: int | None, posed: "PosedRecording") -> int:
    people = [track.person for track in posed.tracks]
    if wanted is not None and wanted not in people:
        raise RecordingError(
            "There is no person {person}. Choose one of: {people}.",
            person=wanted,
            people=", ".join(map(str, people)),
        )
    return people[0] if wanted is None else wanted


def _tell_sides(posed: "PosedRecording", console: Console) -> None:
    """Say which side of everybody is seen, and how sure that is: left and right hang on it."""
    for track, facts in zip(posed.tracks, posed.facts, strict=True):
        console.say(
            _(
                "Person {person}: the front is seen in {front:.0f} % of the frames, found out with "
                "a confidence of {sure:.0f} %."
            ).format(
                person=track.person,
                front=100 * facts.front_share,
                sure=100 * facts.view_confidence,
            )
        )


def _tell(posed: "PosedRecording", paths: list[Path], person: int, console: Console) -> None:
    n_people = len(posed.tracks)
    people = translate_plural("{n} person", "{n} people", n_people).format(n=n_people)
    for path in paths:
        if n_people > 1 and path.suffix.lower() in KINDS_OF_ONE:
            text = _(
                "{file}: joints of person {person} in {n} frames, found without markers. "
                "{people} were seen: --person chooses one."
            )
        else:
            text = _("{file}: joints of {people} in {n} frames, found without markers.")
        console.say(text.format(file=path, person=person, people=people, n=posed.n_frames))
    console.say(
        _("Smoothing uses {n} later frames ({ms:.0f} ms).").format(
            n=posed.lag_frames, ms=1000.0 * posed.lag_s
        )
    )
