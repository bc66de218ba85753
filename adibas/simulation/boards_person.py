"""The stand-in for the person who holds a board: flat, as if cut out of cardboard."""

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.board import Board
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.boards_look import SKIN_SRGB, Hand

BEHIND_M = 0.45
"""From the board's middle to the person."""
TROUSERS, SHIRT, HAIR = (62.0, 68.0, 84.0), (150.0, 60.0, 66.0), (58.0, 44.0, 36.0)
SHOULDER_M, SHOULDER_UP_M = 0.19, 1.42
FINGER_RADIUS_M, PALM_RADIUS_M = 0.009, 0.034
FINGER_M, GRIP_M = 0.065, 0.012
_BODY = (
    ((-0.11, -0.03), (-0.10, -0.86), 0.078, TROUSERS),
    ((0.11, -0.03), (0.10, -0.86), 0.078, TROUSERS),
    ((0.0, -0.98), (0.0, -1.33), 0.17, SHIRT),
    ((0.0, -1.40), (0.0, -1.50), 0.055, SKIN_SRGB),
    ((0.0, -1.66), (0.0, -1.67), 0.105, HAIR),
    ((0.0, -1.61), (0.0, -1.63), 0.095, SKIN_SRGB),
)
"""Both ends from between the feet (x right, y down), radius, sRGB."""


def holding_hands(board: Board, margin_squares: float, *, is_careless: bool) -> tuple[Hand, ...]:
    """Return the hands that hold the paper's left and right border.

    Careless ones reach in so far that fingers lie on the outer corners of one row.
    """
    side_m = board.square_m
    paper_m = (1.0 + margin_squares) * side_m
    row_m = (board.rows // 2) * side_m
    reach_m = paper_m + FINGER_RADIUS_M if is_careless else GRIP_M
    hands = []
    for edge_m, outward in ((-paper_m, -1.0), ((board.columns - 1) * side_m + paper_m, 1.0)):
        tip_m = edge_m - outward * reach_m
        palm_m = tip_m + outward * FINGER_M
        hands.append(Hand((palm_m, row_m - 0.018), (palm_m, row_m + 0.018), PALM_RADIUS_M))
        hands += [
            Hand((palm_m, row_m + finger_m), (tip_m, row_m + 1.2 * finger_m), FINGER_RADIUS_M)
            for finger_m in (-0.022, 0.0, 0.022)
        ]
    return tuple(hands)


def figure(
    world_from_board: RigidTransform, board: Board, margin_squares: float
) -> tuple[RigidTransform, FloatArray, FloatArray]:
    """Return the person who holds the board: frame, strokes and colours.

    Returns
    -------
    world_from_plane : RigidTransform
        The plane stands upright behind the board, its origin on the floor; world axes as of
        `adibas.simulation.room`.
    strokes : (N, 5) array
        Both ends and radius, metres.
    srgb : (N, 3) array
    """
    side_m = board.square_m
    middle_m = world_from_board.apply(board.points_m().mean(axis=0))
    origin_m = np.array([middle_m[0], 0.0, middle_m[2] + BEHIND_M])
    parts = list(_BODY)
    paper_m = (1.0 + margin_squares) * side_m
    row_m = 0.5 * (board.rows - 1) * side_m
    for edge_m in (-paper_m - 0.05, (board.columns - 1) * side_m + paper_m + 0.05):
        hand_m = world_from_board.apply(np.array([edge_m, row_m, 0.0])) - origin_m
        side = 1.0 if hand_m[0] > 0.0 else -1.0
        shoulder_m = (side * SHOULDER_M, -SHOULDER_UP_M)
        hand = (float(hand_m[0]), float(hand_m[1]))
        elbow = (
            0.5 * (shoulder_m[0] + hand[0]) + side * 0.08,
            0.5 * (shoulder_m[1] + hand[1]) + 0.06,
        )
        parts += [(shoulder_m, elbow, 0.05, SHIRT), (elbow, hand, 0.036, SKIN_SRGB)]
    strokes = np.array([(*begin, *end, radius) for begin, end, radius, _ in parts])
    srgb = np.array([color for *_, color in parts])
    return RigidTransform(np.eye(3), origin_m), strokes, srgb
