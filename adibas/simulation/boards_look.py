"""A board before a camera, what hides it, the light on it, and the camera's faults."""

import math
from dataclasses import dataclass, field

from adibas.data.board import Board
from adibas.geometry.rigid import RigidTransform
from adibas.simulation.boards_background import Background
from adibas.simulation.color_noise import ColorNoise

SKIN_SRGB = (196.0, 146.0, 118.0)


@dataclass(frozen=True, slots=True)
class Hand:
    """A finger, palm or arm on the board: a rounded stroke in the board's plane.

    Attributes
    ----------
    begin_m, end_m : (x, y)
        Of its middle line, in the board's frame.
    radius_m : float
    srgb : (r, g, b)
    """

    begin_m: tuple[float, float]
    end_m: tuple[float, float]
    radius_m: float
    srgb: tuple[float, float, float] = SKIN_SRGB


@dataclass(frozen=True, slots=True, eq=False)
class BoardView:
    """One board before one camera.

    Attributes
    ----------
    board : Board
    camera_from_board : RigidTransform
        See `adibas.data.board` for the board's frame.
    has_marks : bool
        Whether it has the dots of `Board.marked_squares`.
    margin_squares : float
        White paper around the outer squares, in squares.
    hands : tuple of Hand
        What hides parts of it; a later one lies over an earlier one.
    """

    board: Board
    camera_from_board: RigidTransform
    has_marks: bool = True
    margin_squares: float = 1.0
    hands: tuple[Hand, ...] = ()


@dataclass(frozen=True, slots=True)
class BoardLook:
    """Light, paper and camera; the defaults are a Kinect-class colour camera in a clinic.

    Attributes
    ----------
    camera : ColorNoise
        Blur (`blur_px` is at 1280 pixels' width, and scales with it), noise, light lost in the
        corners, and for pictures in colour the mosaic.
    paper, ink : float
        Linear reflectance: white paper and laser print (assumed).
    exposure : float
        White paper in plain light, as a share of full scale.
    light_gradient : float
        How much brighter than in the middle it is at the image's border, half a diagonal away,
        and how much darker at the opposite one (assumed).
    light_from_rad : float
        Where the light comes from, in the image: 0 = right, a quarter turn = below.
    motion_px : (du, dv)
        Way of the board in the image during the exposure, its middle being the truth.
    background : Background
    is_mirrored : bool
        Left and right exchanged in the finished picture, and in its corners.
    """

    camera: ColorNoise = field(default_factory=ColorNoise)
    paper: float = 0.82
    ink: float = 0.05
    exposure: float = 0.8
    light_gradient: float = 0.15
    light_from_rad: float = math.radians(215.0)
    motion_px: tuple[float, float] = (0.0, 0.0)
    background: Background = field(default_factory=Background)
    is_mirrored: bool = False
