"""What is expected of points before they are looked at, when they are named by core and limbs."""

import math
from dataclasses import dataclass

import numpy as np

from adibas.arrays import FloatArray
from adibas.shapes.parts_types import Odds
from adibas.skeleton.parts import ARMS, PartsModel
from adibas.skeleton.starts import HEADINGS_RAD


@dataclass(frozen=True, slots=True)
class Effort:
    """How far is searched: see `Odds`."""

    n_judged: int
    n_varied: int
    too_unlikely: float


HOLDING_STILL = 0.8
"""How often people who hold still for a capture stand as those of the training.

0.5 to 0.9 name simulated people and those of Plug-in-Gait files alike.
"""
QUICK = Effort(5, 3, 20.0)
THOROUGH = Effort(100, 5, 60.0)
"""Where the quick search leaves a doubt, or points are missing or too many."""


@dataclass(frozen=True, slots=True)
class PartsOdds:
    """What is expected before the points are looked at, and when a name is given.

    Attributes
    ----------
    complete : float
        How often no label is hidden: 0.8; of the rest, one more halves it.
    clean : float
        How often there is no point too many: 0.8; of the rest, one more halves it.
    room_m3 : float
        Where a point without a label may be: 3, a person's reach and a little more.
    lone : float
        Least that one more label without a point costs, in nats: 3.
    kappa : float
        Concentration of a patient's heading about the declared view: 4.
    gap : float
        Ways less likely than the best by so much, in nats, do not count: 9.
    side_divisor : float
        Of the log odds that a patient faces the other way, where no view is told: 7; real people
        differ more than simulated ones.
    arms_free : float
        How often arms are as in any kind of posture, whatever the rest of the body does: 0.05.
        Legs carry the body, and are as the rest tells.
    legs_apart_m, legs_apart_sd_m : float
        How near the bones of both legs may come, and how surely that is known: 30 and 20 mm.
    legs_through : float
        How often places say that legs go through each other all the same: 0.02.
    stands : float
        How often somebody stands still as those whose joints are known together (`Stance`), where a
        view is declared: 0, for people who move; `HOLDING_STILL` for those who do not.
    arm_elsewhere, leg_elsewhere : float
        How often one arm or leg of theirs is elsewhere, and as often its outer bone alone: 0.005
        and 0.001. Without these, bent forearms would be taken for chance points.
    temperature : float
        By which differences of energy are divided before they are log odds.
    sure : float
        Least confidence of a name that is given: 0.5.
    side_sure : float
        A name is not given where its mirror image is more probable than this: 0.25.
    n_anchored : int
        Cores from single points: 160, where the quick search leaves a doubt.
    usual : float
        The points of a person are 60 to 100 nats likelier than chance ones. Where the quick search
        finds less than 55, it may have missed the person.
    plausible : float
        Least nats for each named point: 2.5. Less are no person, or no joints (thesis, section
        6.1.2: p(b) >= p_t). Of 160 simulated sets with up to four hidden and four chance points 1 %
        have less, of 60 clouds of chance points all.
    plausible_by_sight : float
        Or so many, if labels that are out of sight are not counted as hidden: 3.2. Of 1,131 bands
        of 5 to 14 markers of people who stand or are in the middle of a gesture, all of whose most
        probable names are right, 98 % have more; of 47 where one is wrong 23.
    """

    complete: float = 0.8
    clean: float = 0.8
    room_m3: float = 3.0
    lone: float = 3.0
    kappa: float = 4.0
    gap: float = 9.0
    side_divisor: float = 7.0
    arms_free: float = 0.05
    legs_apart_m: float = 0.03
    legs_apart_sd_m: float = 0.02
    legs_through: float = 0.02
    stands: float = 0.0
    arm_elsewhere: float = 0.005
    leg_elsewhere: float = 0.001
    temperature: float = 1.0
    sure: float = 0.5
    side_sure: float = 0.25
    n_anchored: int = 160
    usual: float = 55.0
    plausible: float = 2.5
    plausible_by_sight: float = 3.2


def expected_odds(
    model: PartsModel, label_odds: FloatArray, view: str, odds: PartsOdds, effort: Effort
) -> Odds:
    """Return what is expected of points of a view (empty: unknown); `label_odds` as in `Odds`."""
    n_points, n = label_odds.shape
    counts = np.full(n + 1, np.inf)
    for n_missing in range(n + 1):
        n_spurious = n_points - (n - n_missing)
        if n_spurious >= 0:
            counts[n_missing] = (
                _count_cost(n_missing, odds.complete)
                + math.log(math.comb(n, n_missing))
                + _count_cost(n_spurious, odds.clean)
                - math.lgamma(n_spurious + 1)
            )
    mixed = np.zeros(len(model.limbs.roots))
    mixed[ARMS] = odds.arms_free
    return Odds(
        n_kinds=len(model.kinds),
        log_room=math.log(odds.room_m3),
        counts=counts,
        least_counts=np.ascontiguousarray(np.minimum.accumulate(counts[::-1])[::-1]),
        lone=odds.lone,
        kappa=odds.kappa,
        heading_rad=HEADINGS_RAD[view] if view else math.nan,
        gap=odds.gap * odds.temperature,
        side_divisor=odds.side_divisor,
        mixed=mixed,
        label_odds=label_odds,
        n_judged=effort.n_judged,
        n_varied=effort.n_varied,
        too_unlikely=effort.too_unlikely,
    )


def hidden_costs(n_names: int, odds: PartsOdds) -> FloatArray:
    """Return the (N + 1, N + 1) costs of so many labels out of sight (row), so many others hidden.

    Minus the log probability of one such choice of labels; infinite where there are not so many.
    """
    costs = np.full((n_names + 1, n_names + 1), np.inf)
    for n_out in range(n_names + 1):
        for n_hidden in range(n_names - n_out + 1):
            n_ways = math.comb(n_names - n_out, n_hidden)
            costs[n_out, n_hidden] = _count_cost(n_hidden, odds.complete) + math.log(n_ways)
    return costs


def _count_cost(n: int, none: float) -> float:
    """Return minus the log probability of n, where none is most probable and each more halves."""
    return -math.log(none if n == 0 else (1.0 - none) * 0.5**n)
