"""Someone carries a board about before a camera: stops, tilts it, walks on, and begins anew."""

import math
from dataclasses import dataclass, field

import numpy as np

from adibas.arrays import FloatArray
from adibas.data.board import Board
from adibas.data.calibration import CameraCalibration
from adibas.geometry.rigid import RigidTransform, rotation_from_vector, rotation_vector
from adibas.simulation.boards_poses import Holding, random_board_poses

TREMOR_HZ = (0.43, 1.1, 2.3)


@dataclass(frozen=True, slots=True)
class WalkHabits:
    """How the board is carried.

    Attributes
    ----------
    n_stations : int
        Stops before it all begins again.
    stop_s : float
        How long each lasts.
    speed_m_s, turn_rad_s : float
        Mean speed of the board's middle on the way, and of its turning; the slower of both
        decides (assumed).
    shortest_move_s : float
    tremor_m, tremor_rad : float
        Standard deviation of place and angle while the hands hold it (assumed).
    holding : Holding
        Of the stations; no farther than 2.8 m, so that a person stands behind it in a room.
    """

    n_stations: int = 22
    stop_s: float = 1.5
    speed_m_s: float = 0.7
    turn_rad_s: float = math.radians(50.0)
    shortest_move_s: float = 0.7
    tremor_m: float = 0.0004
    tremor_rad: float = math.radians(0.04)
    holding: Holding = field(default_factory=lambda: Holding(distance_m=(0.6, 2.8)))


@dataclass(frozen=True, slots=True, eq=False)
class Stance:
    """A pose as numbers that can be mixed: middle of the pattern, tilt about x and y, and roll."""

    middle_m: FloatArray
    tilt_rad: FloatArray
    roll_rad: float


class Walk:
    """The way of a board; any time may be asked for.

    Attributes
    ----------
    duration_s : float
        After which it begins again.
    """

    def __init__(
        self, board: Board, camera: CameraCalibration, rng: np.random.Generator, habits: WalkHabits
    ) -> None:
        self._board = board
        self._habits = habits
        poses = random_board_poses(rng, board, camera, habits.n_stations, habits.holding)
        self._stations = _in_order([_stance(pose, board) for pose in poses])
        moves_s = [
            self._move_s(here, there)
            for here, there in zip(
                self._stations, self._stations[1:] + self._stations[:1], strict=True
            )
        ]
        self._arrivals_s = np.concatenate([[0.0], np.cumsum(np.add(moves_s, habits.stop_s))])
        self.duration_s = float(self._arrivals_s[-1])
        self._phases_rad = rng.uniform(0.0, 2.0 * math.pi, (6, len(TREMOR_HZ)))

    def pose_at(self, time_s: float) -> RigidTransform:
        """Return `camera_from_board`."""
        station, share = self._progress(time_s)
        here = self._stations[station]
        there = self._stations[(station + 1) % len(self._stations)]
        # Hands start and stop softly: least jerk (Flash & Hogan 1985).
        share = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        tremor = self._tremor(time_s)
        middle_m = here.middle_m + share * (there.middle_m - here.middle_m) + tremor[:3]
        tilt_rad = here.tilt_rad + share * (there.tilt_rad - here.tilt_rad)
        roll_rad = here.roll_rad + share * (there.roll_rad - here.roll_rad)
        rotation = (
            rotation_from_vector(tremor[3:])
            @ rotation_from_vector(np.array([*tilt_rad, 0.0]))
            @ rotation_from_vector(np.array([0.0, 0.0, roll_rad]))
        )
        return RigidTransform(rotation, middle_m - rotation @ _middle_m(self._board))

    def station_at(self, time_s: float) -> int | None:
        """Return at which stop the board is held, from 0; None on the way."""
        station, share = self._progress(time_s)
        return station if share == 0.0 else None

    def last_station(self, time_s: float) -> int:
        """Return at which stop it is held, or was before the way it is on."""
        return self._progress(time_s)[0]

    def _progress(self, time_s: float) -> tuple[int, float]:
        """Return the last station and the share of the way to the next, 0 while it is held."""
        time_s %= self.duration_s
        station = int(np.searchsorted(self._arrivals_s, time_s, side="right")) - 1
        station = min(station, len(self._stations) - 1)
        left_s = self._arrivals_s[station] + self._habits.stop_s
        move_s = self._arrivals_s[station + 1] - left_s
        return station, max(float(time_s - left_s) / float(move_s), 0.0)

    def _move_s(self, here: Stance, there: Stance) -> float:
        way_s = float(np.linalg.norm(there.middle_m - here.middle_m)) / self._habits.speed_m_s
        turn_rad = math.hypot(*(there.tilt_rad - here.tilt_rad), there.roll_rad - here.roll_rad)
        return max(way_s, turn_rad / self._habits.turn_rad_s, self._habits.shortest_move_s)

    def _tremor(self, time_s: float) -> FloatArray:
        turns = 2.0 * math.pi * np.array(TREMOR_HZ) * time_s
        waves = np.sin(turns + self._phases_rad).sum(axis=1) * math.sqrt(2.0 / len(TREMOR_HZ))
        sizes = np.repeat([self._habits.tremor_m, self._habits.tremor_rad], 3)
        tremor: FloatArray = sizes * waves
        return tremor


def _middle_m(board: Board) -> FloatArray:
    middle: FloatArray = board.points_m().mean(axis=0)
    return middle


def _stance(pose: RigidTransform, board: Board) -> Stance:
    normal = pose.rotation[:, 2]
    axis = np.array([-normal[1], normal[0], 0.0])
    sine = float(np.linalg.norm(axis))
    tilt = axis * (math.atan2(sine, normal[2]) / sine if sine > 0.0 else 0.0)
    roll = rotation_vector(rotation_from_vector(tilt).T @ pose.rotation)
    return Stance(pose.apply(_middle_m(board)), tilt[:2], float(roll[2]))


def _in_order(stances: list[Stance]) -> list[Stance]:
    """Return the stations so that each is followed by the nearest one not yet visited."""
    left, ordered = stances[1:], stances[:1]
    while left:
        here = ordered[-1].middle_m
        nearest = min(range(len(left)), key=lambda i: np.linalg.norm(left[i].middle_m - here))
        ordered.append(left.pop(nearest))
    return ordered
