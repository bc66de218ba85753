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
        **corners_to_json(corners),
    }


def corners_to_json(corners: BoardCorners) -> dict[str, Any]:
    """Return the document of corners; whose they are stands elsewhere."""
    return {
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
    corners = _corners(document, document)
    blur_px = _or_nan(document["blur_px"])
    size = (corners.height, corners.width)
    return SearchedImage(corners.image, size, BoardSearch(corners), blur_px)


def still_from_json(document: Document) -> BoardCorners | None:
    """Return the mean corners of the time of a picture's depth; None where it has none.

    Raises
    ------
    ValueError, KeyError, TypeError
        It is no document of a picture.
    """
    return _corners(document, document["still"]) if "still" in document else None


def _corners(document: Document, found: Document) -> BoardCorners:
    """Return corners `found` in the picture of a document."""
    height, width = (int(side) for side in document["size"])
    is_mirrored = found["is_mirrored"]
    corners = BoardCorners(
        image=str(document["name"]),
        width=width,
        height=height,
        pixels=np.array([[_or_nan(u), _or_nan(v)] for u, v in found["pixels"]]).reshape(-1, 2),
        sigma_px=np.array([_or_nan(sigma) for sigma in found["sigma_px"]]),
        is_mirrored=None if is_mirrored is None else bool(is_mirrored),
    )
    if len(corners.pixels) != board_from_json(document["board"]).n_corners:
        raise ValueError("the picture has another number of corners than its board")
    return corners


def _or_none(value: float) -> float | None:
    return None if math.isnan(value) else value


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else float(value)
