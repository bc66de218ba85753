"""Rendered boards of a thousand devices, searched once and kept: a long run can be gone on with.

`python -m benchmarks.calibration_rendered FIRST LAST` searches the sets FIRST to LAST - 1 that are
not in the folder yet, one after the other; the benchmark then takes them from there.
"""

import json
import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from adibas.arrays import FloatArray
from adibas.calibration.finder import BoardProblem, BoardSearch
from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration
from adibas.data.printed_boards import PRINTED_BOARDS
from adibas.files import written_whole
from adibas.geometry.rigid import RigidTransform
from adibas.pipeline.calibrating import NamedImage, SearchedImage, search_image
from adibas.pipeline.calibration_documents import searched_from_json, searched_to_json
from adibas.simulation.boards import render_board, visible_corners
from adibas.simulation.boards_look import BoardView
from adibas.simulation.boards_poses import random_board_poses
from adibas.simulation.device import draw_device

FOLDER = "ADIBAS_BENCHMARK_FOLDER"
"""Of the environment: where sets are kept; nothing is kept without it."""
SEED = 4242
N_VIEWS = 20
BOARD: Board = PRINTED_BOARDS["A3"].board


@dataclass(frozen=True, slots=True, eq=False)
class RenderedSet:
    """The pictures of one simulated device.

    Attributes
    ----------
    camera : CameraCalibration
        The truth.
    images : tuple of SearchedImage
        What was found in each.
    corners_px : tuple of (n, 2) arrays
        Where the corners are in truth.
    """

    camera: CameraCalibration
    images: tuple[SearchedImage, ...]
    corners_px: tuple[FloatArray, ...]

    @property
    def squared_px(self) -> FloatArray:
        """Squared distance of each corner that was found from the truth."""
        squares = [
            ((image.search.corners.pixels - truth) ** 2).sum(axis=1)
            for image, truth in zip(self.images, self.corners_px, strict=True)
            if image.search.corners is not None
        ]
        found = np.concatenate(squares) if squares else np.empty(0)
        return np.asarray(found[~np.isnan(found)])


def rendered_set(seed: int) -> RenderedSet:
    """Return the pictures of device `seed`, from the folder where they are there."""
    camera = draw_device(seed).color
    rng = np.random.default_rng([SEED, seed])
    poses = random_board_poses(rng, BOARD, camera, N_VIEWS)
    path = _path(seed)
    if path is not None and path.exists():
        images = tuple(_image_from(one) for one in json.loads(path.read_text("utf-8")))
    else:
        images = _searched(poses, camera, rng)
        if path is not None:
            with written_whole(path) as unfinished:
                unfinished.write_text(json.dumps([_image_to(one) for one in images]), "utf-8")
    truth = tuple(visible_corners(BoardView(BOARD, pose), camera) for pose in poses)
    return RenderedSet(camera, images, truth)


def _searched(
    poses: tuple[RigidTransform, ...], camera: CameraCalibration, rng: np.random.Generator
) -> tuple[SearchedImage, ...]:
    return tuple(
        search_image(NamedImage(f"{i:02d}", render_board(BOARD, pose, camera, rng).image), BOARD)
        for i, pose in enumerate(poses)
    )


def _path(seed: int) -> Path | None:
    folder = os.environ.get(FOLDER)
    return None if folder is None else Path(folder) / f"rendered-{seed:04d}.json"


def _image_to(searched: SearchedImage) -> dict[str, Any]:
    problem = searched.search.problem
    if problem is None:
        return searched_to_json(searched, BOARD)
    return {"name": searched.name, "size": list(searched.size), "problem": problem.value}


def _image_from(document: Mapping[str, Any]) -> SearchedImage:
    if "problem" not in document:
        return searched_from_json(document)
    height, width = document["size"]
    search = BoardSearch(None, BoardProblem(document["problem"]))
    return SearchedImage(document["name"], (height, width), search, float("nan"))


def _go_on(first: int, last: int) -> None:
    if os.environ.get(FOLDER) is None:
        raise SystemExit(f"Say in {FOLDER} where the sets are kept.")
    cv2.setNumThreads(1)
    for seed in range(first, last):
        path = _path(seed)
        if path is not None and not path.exists():
            rendered_set(seed)


if __name__ == "__main__":
    _go_on(int(sys.argv[1]), int(sys.argv[2]))
