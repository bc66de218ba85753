"""A board, and what was found of it in a picture, as JSON and back without any loss."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from adibas.calibration.finder import BoardSearch
from adibas.data.board import Board, BoardCorners
from adibas.pipeline.calibrating import SearchedImage

Document = Mapping[str, Any]


def board_to_json(board: Board) -> dict[str, Any]:
    """Return the document of a board."""
    return {"columns": board.columns, "rows": board.rows, "square_m": board.square_m}


def board_from_json(document: Document) -> Board:
    """Return the board of a document.

    Raises
    ------
    ValueError, KeyError, TypeError
        It is no document of a board.
    """
    return Board(int(document["columns"]), int(document["rows"]), float(document["square_m"]))


def searched_to_json(searched: SearchedImage, board: Board) -> dict[str, Any]:
    """Return the document of a picture in which a board was found."""
    corners = searched.search.corners
    if corners is None:
        raise ValueError("only pictures of a board are kept")
    return {
        "board": board_to_json(board),
        "name": searched.name,
        "size": list(searched.size),
        "blur_px": _or_none(searched.blur_px),
        "pixels": [[_or_none(u), _or_none(v)] for u, v in corners.pixels.tolist()],
        "sigma_px": [_or_none(sigma) for sigma in corners.sigma_px.tolist()],
        "is_mirrored": corners.is_mirrored,
    }


def searched_from_json(document: Document) -> SearchedImage:
    """Return what was found in a picture.

    Raises
    ------
    ValueError, KeyError, TypeError
        It is no document of a picture.
    """
    height, width = (int(side) for side in document["size"])
    is_mirrored = document["is_mirrored"]
    corners = BoardCorners(
        image=str(document["name"]),
        width=width,
        height=height,
        pixels=np.array([[_or_nan(u), _or_nan(v)] for u, v in document["pixels"]]).reshape(-1, 2),
        sigma_px=np.array([_or_nan(sigma) for sigma in document["sigma_px"]]),
        is_mirrored=None if is_mirrored is None else bool(is_mirrored),
    )
    if len(corners.pixels) != board_from_json(document["board"]).n_corners:
        raise ValueError("the picture has another number of corners than its board")
    blur_px = _or_nan(document["blur_px"])
    return SearchedImage(corners.image, (height, width), BoardSearch(corners), blur_px)


def _or_none(value: float) -> float | None:
    return None if math.isnan(value) else value


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else float(value)
