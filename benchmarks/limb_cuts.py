"""The cut beside a loop that makes each binary cut with PyMaxflow: time, and where it ends."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

from adibas.arrays import AnyArray, BoolArray, Float32Array
from adibas.forests.forest import Forest
from adibas.graphcut.boundary import boundary_weights
from adibas.graphcut.energy import EnergyParams, LabelEnergy, equal_penalties, label_energy
from adibas.graphcut.minimising import Labelling, cheapest_labels, expand, minimise, start_labels
from adibas.graphcut.neighbors import connect_pixels
from adibas.limbs.penalties import omega_2
from adibas.limbs.segmentation import LimbParams
from benchmarks.graph_cut_peer import pairs_of, peer_expand, peer_swap, plain_energy
from benchmarks.limb_frames import FOCAL_PX, LimbFrames
from benchmarks.table import Row
from benchmarks.works import median_ms, medians_ms

OTHER_POSES = 6201
SMOOTHNESS = (LimbParams().smoothness, 10.0, 50.0)
"""What the program takes where nothing is said, and stronger ones, up to the thesis'."""
CUT_GOAL = 4.0
"""How many times as fast as a loop with PyMaxflow a cut is to be, at equal energy."""
Frame = tuple[Float32Array, BoolArray, Float32Array]
"""Depth, mask, and probabilities of the labels at its pixels."""


@dataclass(frozen=True, slots=True)
class _Compared:
    """Both loops on one frame."""

    ours_ms: float
    peer_ms: float
    ours_energy: int
    peer_energy: int


def cut_rows(forest: Forest, n_frames: int, n_rounds: int) -> Iterator[Row]:
    """Cut people in poses that the forest has not seen, by its own probabilities."""
    images = LimbFrames(n_frames, forest.labels, OTHER_POSES)
    frames: list[Frame] = []
    for index in range(n_frames):
        depth_m, mask = images.person(index)
        frames.append((depth_m, mask, forest.probabilities(depth_m, mask, FOCAL_PX)))
    n_labels = len(forest.labels)
    tables = {
        "Omega_1, expansion": equal_penalties(n_labels),
        "Omega_2, swap": omega_2(forest.labels),
    }
    for smoothness in SMOOTHNESS:
        for name, table in tables.items():
            energies = [_energy(frame, table, smoothness) for frame in frames]
            title = f"{n_labels} labels, frames: {n_frames}, {name}, lambda {smoothness:g}"
            yield from _compare_cuts(title, energies, n_rounds)
    yield _whole_cut(frames[0], n_rounds)


def _energy(frame: Frame, table: AnyArray, smoothness: float) -> LabelEnergy:
    depth_m, mask, probabilities = frame
    graph = connect_pixels(mask)
    boundary = boundary_weights(graph, depth_m)
    return label_energy(graph, probabilities, boundary, table, EnergyParams(smoothness))


def _compare_cuts(title: str, energies: list[LabelEnergy], n_rounds: int) -> Iterator[Row]:
    """Time the program's way beside the loop that one writes with PyMaxflow.

    That loop begins from the likeliest labels. Where ours seeks a better start, the same is
    measured once more with both from the likeliest.
    """
    yield from _compared_rows(f"{title}, as each is used", energies, minimise, n_rounds)
    if energies[0].is_metric and any(_seeks_a_start(energy) for energy in energies):
        name = f"{title}, both from likeliest labels"
        yield from _compared_rows(name, energies, _expand_likeliest, n_rounds)


def _seeks_a_start(energy: LabelEnergy) -> bool:
    return bool((start_labels(energy) != cheapest_labels(energy)).any())


def _expand_likeliest(energy: LabelEnergy) -> Labelling:
    return expand(energy, cheapest_labels(energy))


def _compared_rows(
    name: str,
    energies: list[LabelEnergy],
    ours: Callable[[LabelEnergy], Labelling],
    n_rounds: int,
) -> Iterator[Row]:
    found = [_compare(energy, ours, n_rounds) for energy in energies]
    ours_ms = sum(one.ours_ms for one in found)
    peer_ms = sum(one.peer_ms for one in found)
    yield Row(f"cuts of {name}", ours_ms, "ms CPU", peer_ms, "PyMaxflow loop")
    yield Row("same: times faster", peer_ms / ours_ms, "", CUT_GOAL, "goal >=")
    slowest = min(one.peer_ms / one.ours_ms for one in found)
    yield Row("same: times faster, the slowest of them", slowest, "")
    more = sum(one.ours_energy - one.peer_energy for one in found)
    yield Row("same: energy of all more than PyMaxflow's", more, "units", 0, "goal <=")
    n_more = sum(one.ours_energy > one.peer_energy for one in found)
    yield Row("same: energies above PyMaxflow's", n_more, f"of {len(found)}")
    n_less = sum(one.ours_energy < one.peer_energy for one in found)
    yield Row("same: energies below PyMaxflow's", n_less, f"of {len(found)}")


def _compare(
    energy: LabelEnergy, ours: Callable[[LabelEnergy], Labelling], n_rounds: int
) -> _Compared:
    peer = partial(peer_expand if energy.is_metric else peer_swap, energy, cheapest_labels(energy))
    ours_ms, peer_ms = medians_ms([partial(ours, energy), peer], n_rounds)
    peer_energy = plain_energy(energy, pairs_of(energy), peer()[0])
    return _Compared(ours_ms, peer_ms, ours(energy).energy, peer_energy)


def _whole_cut(frame: Frame, n_rounds: int) -> Row:
    """Time everything from probabilities to labels, as it runs live."""
    n_labels = frame[2].shape[1]

    def work() -> object:
        return expand(_energy(frame, equal_penalties(n_labels), SMOOTHNESS[0]))

    name = f"graph, energy, start and cut, {n_labels} labels"
    return Row(f"{name}, lambda {SMOOTHNESS[0]:g}", median_ms(work, n_rounds), "ms CPU")
