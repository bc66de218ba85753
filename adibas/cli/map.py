"""`adibas map`: a recording of a moving camera in, its path and one coloured surface out."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from adibas.cli.console import Console
from adibas.cli.interrupts import kept_when_stopped
from adibas.cli.options import add_json
from adibas.cli.recording_options import add_calibration, add_frames, add_recording
from adibas.cli.report_options import check_surface
from adibas.errors import FileError
from adibas.files import check_place
from adibas.texts import message, translate_plural
from adibas.texts import translate as _

if TYPE_CHECKING:
    from adibas.pipeline.mapping import MappedRecording

SUMMARY = message("put the frames of a moving camera together into one surface")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    add_recording(parser)
    add_calibration(parser)
    add_frames(parser, _("frames to look at, B not included; all of them if not given"))
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        metavar="map.ply",
        help=_("surface to write: points with normals, colours and radii"),
    )
    parser.add_argument(
        "--trajectory",
        type=Path,
        metavar="trajectory.txt",
        help=_("path of the camera to write, in TUM's format"),
    )
    parser.add_argument(
        "--body",
        action="store_true",
        help=_("map the person alone, who turns before a camera that stands still"),
    )
    parser.add_argument(
        "--pose-graph",
        choices=("scipy", "gtsam"),
        default="scipy",
        help=_("who spreads the drift over loops; gtsam is the extra pip install 'adibas[gtsam]'"),
    )
    add_json(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Map and write the files."""
    from adibas.pipeline.map_state import unfinished_path
    from adibas.reports.map_files import map_to_json, motion_sentence

    check_surface(arguments.out)
    if arguments.trajectory is not None:
        check_place(arguments.trajectory)
        if arguments.trajectory.resolve() == arguments.out.resolve():
            raise FileError(
                "{file} cannot hold both the surface and the path. Choose another name for one.",
                file=arguments.out.name,
            )
    with kept_when_stopped(unfinished_path(arguments.out)):
        mapped = _map_and_write(arguments, console)
    for notice in mapped.notices:
        console.warn(notice.text)
    n_placed = len(mapped.world_from_camera)
    console.say(
        _("{file}: {points} from {placed} of {frames} frames, {loops}.").format(
            file=arguments.out,
            points=translate_plural("{n} point", "{n} points", len(mapped.surface.points_m)).format(
                n=len(mapped.surface.points_m)
            ),
            placed=n_placed,
            frames=mapped.n_frames,
            loops=translate_plural("{n} loop", "{n} loops", mapped.n_loops).format(
                n=mapped.n_loops
            ),
        )
    )
    if mapped.motion is not None:
        console.say(motion_sentence(mapped.motion).text)
    console.give(map_to_json(mapped))
    return 0


def _map_and_write(arguments: argparse.Namespace, console: Console) -> "MappedRecording":
    from adibas.alignment.camera_track import KeyFrameParams
    from adibas.alignment.pose_graph import GraphParams
    from adibas.pipeline.mapping import MapRequest, forget_unfinished, map_recording
    from adibas.reports.map_files import write_ply, write_trajectory

    request = MapRequest(
        arguments.recording,
        arguments.calibration,
        arguments.frames,
        arguments.body,
        tracking=KeyFrameParams(graph=GraphParams(solver=arguments.pose_graph)),
        out=arguments.out,
    )
    with console.progress(_("Mapping")) as progress:
        mapped = map_recording(request, progress)
    write_ply(mapped.surface, arguments.out)
    if arguments.trajectory is not None:
        write_trajectory(mapped, arguments.trajectory)
    forget_unfinished(request)
    return mapped
