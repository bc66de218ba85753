"""A skeleton model at work: it chooses its part that fits the points, and keeps it prepared."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from adibas.arrays import BoolArray, FloatArray, IntArray
from adibas.skeleton.body_marks import BodyOdds
from adibas.skeleton.given_names import given_index, nothing_given
from adibas.skeleton.known import Known
from adibas.skeleton.labelling import Labelling, label_points, nothing_told
from adibas.skeleton.model import SkeletonModel
from adibas.skeleton.parts_naming import MOST_POINTS, NamedByParts, label_parts
from adibas.skeleton.parts_odds import HOLDING_STILL, PartsOdds
from adibas.skeleton.postures import NearestPosture, nearest_posture
from adibas.skeleton.prepared import PreparedModel, prepare
from adibas.skeleton.prototype_search import LEAST_POINTS, LabelParams
from adibas.skeleton.second_opinion import combined, is_in_doubt, named_by
from adibas.skeleton.seen_space import EVERYWHERE, SeenSpace
from adibas.skeleton.sizes import size_log_odds

SPACE = 3
EXTENTS_M = 1e-3, 1e4
"""Points that are all nearer to their middle, or some of them farther from it, are no person's."""
SURE_BY_BODY = 0.85
"""Least confidence of a name where a body is known: of names from 0.5 to 0.85 a third is wrong."""
PLAUSIBLE_BY_BODY = 1.5
"""Least nats for each named point there: that somebody is a person is known already."""
STANDS = 0.5
"""Where somebody more probably than this stands still, nobody else is asked for names."""


class Namer:
    """Names the points of one frame after the other."""

    def __init__(
        self,
        model: SkeletonModel,
        params: LabelParams | None = None,
        odds: PartsOdds | None = None,
    ) -> None:
        self._model = model
        self._params = params or LabelParams()
        self._odds = odds or PartsOdds()
        self._prepared: dict[str, PreparedModel] = {}
        self._body_odds: BodyOdds | None = None

    def holding_still(self) -> "Namer":
        """Return a namer of people who hold still, as in a capture; both share what they know."""
        odds = replace(self._odds, stands=HOLDING_STILL)
        return self._alike(odds, self._body_odds)

    def who_sees(self, body_odds: BodyOdds) -> "Namer":
        """Return a namer that knows where a body is; both share what they know."""
        odds = replace(
            self._odds,
            sure=SURE_BY_BODY,
            plausible=PLAUSIBLE_BY_BODY,
            plausible_by_sight=PLAUSIBLE_BY_BODY,
        )
        return self._alike(odds, body_odds)

    def _alike(self, odds: PartsOdds, body_odds: BodyOdds | None) -> "Namer":
        other = Namer(self._model, self._params, odds)
        other._prepared, other._body_odds = self._prepared, body_odds
        return other

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names that points can get."""
        return self._model.names

    @property
    def identity(self) -> str:
        """Return which model it is: when it was made, and by which version of the program."""
        told = self._model.provenance
        created, version = (told.get(key, "unknown") for key in ("created_utc", "version"))
        return f"model {created} ({version})"

    @property
    def knows_body(self) -> bool:
        """Say whether it knows where a body is."""
        return self._body_odds is not None

    @property
    def provenance(self) -> Mapping[str, object]:
        """Return what the model was learned from."""
        return self._model.provenance

    def knows(self, n_dimensions: int) -> bool:
        """Say whether the model has a part for points of so many dimensions."""
        return bool(self._parts(n_dimensions, ""))

    def posture(self, points_m: FloatArray, view: str, heading_rad: float) -> NearestPosture:
        """Say which posture of the training (M, D) points are nearest to; see `label`."""
        parts = self._parts(points_m.shape[1], view)
        found = [nearest_posture(part.model, points_m, heading_rad) for part in parts]
        return min(found, key=lambda one: one.distance)

    def label(
        self,
        points_m: FloatArray,
        view: str = "",
        diameters_m: FloatArray | None = None,
        given: Sequence[str] = (),
        seen: SeenSpace = EVERYWHERE,
    ) -> Labelling:
        """Name (M, D) points in metres, y down; see `label_points`.

        Parameters
        ----------
        diameters_m : (M,) array or None
            Of the markers, as measured; NaN where one is not known. One that is unlike all others
            is hardly a marker.
        given : sequence of str
            Of each point the name that it has already, empty where it is to be found; nothing: all
            are to be found. The other points get names that agree with these; a point with a name
            that is none of the model's is none of its points.
        seen : SeenSpace
            By the cameras: that a point is missing which must be beyond tells nothing.

        Raises
        ------
        ValueError
            The model has no part for that many dimensions, or a place is not finite: the search
            would not end.
        """
        points_m = np.ascontiguousarray(points_m, float)
        if not np.isfinite(points_m).all():
            raise ValueError("points are named by places that are known")
        sizes = np.zeros(len(points_m)) if diameters_m is None else size_log_odds(diameters_m)
        if not any(given):
            nothing = nothing_given(len(points_m))
            return self._label(points_m, view, self._known(points_m, sizes, nothing, seen))
        is_other = np.array([bool(one) and one not in self.names for one in given], bool)
        own = [one for one in given if not one or one in self.names]
        own_m = points_m[~is_other]
        known = self._known(own_m, sizes[~is_other], given_index(own, self.names), seen)
        return _with_others(self._label(own_m, view, known), is_other)

    def _known(
        self, points_m: FloatArray, sizes: FloatArray, given: IntArray, seen: SeenSpace
    ) -> Known:
        tell, in_space = self._body_odds, points_m.shape[1] == SPACE
        return Known(sizes, given, seen, tell(points_m) if tell is not None and in_space else None)

    def _label(self, points_m: FloatArray, view: str, known: Known) -> Labelling:
        are_joints = self._model.parts is not None and points_m.shape[1] == SPACE
        if are_joints and not _may_be_of_a_person(points_m):
            return nothing_told(len(points_m), len(self.names))
        by_parts = self._by_parts(points_m, view, known)
        if by_parts is None:
            return self._by_prototypes(points_m, view, known)
        labelling = by_parts.labelling
        if by_parts.stands > STANDS or not is_in_doubt(labelling):
            return labelling
        other = self._by_prototypes(points_m, view, known)
        return combined(labelling, other, self.names, self._odds.sure, self._odds.side_sure)

    def _by_parts(self, points_m: FloatArray, view: str, known: Known) -> NamedByParts | None:
        """Return names by core and limbs; None where they are not known or none are found."""
        parts = self._model.parts
        is_some = LEAST_POINTS <= len(points_m) <= MOST_POINTS
        if parts is None or points_m.shape[1] != SPACE or not is_some:
            return None
        prepared = self._part("space")
        return label_parts(parts, prepared, points_m, view, known, self._odds)

    def _by_prototypes(self, points_m: FloatArray, view: str, known: Known) -> Labelling:
        """Return names by prototypes and neighbours, which know of places alone."""
        parts = self._parts(points_m.shape[1], view)
        temperature = self._model.temperature
        found = label_points(parts, points_m, view, self._params, temperature, known.given)
        if not known.tells:
            return found
        masses = known.weighed(found.masses)
        sure = self._params.sure
        return named_by(masses, self.names, found.heading_rad, sure, 1.0 - sure)

    def _parts(self, n_dimensions: int, view: str) -> tuple[PreparedModel, ...]:
        if n_dimensions == SPACE:
            keys = ["space"] if self._model.space is not None else []
        elif view in self._model.planes:
            keys = [view]
        else:
            keys = list(self._model.planes)
        return tuple(self._part(key) for key in keys)

    def _part(self, key: str) -> PreparedModel:
        if key not in self._prepared:
            part = self._model.space if key == "space" else self._model.planes[key]
            if part is None:
                raise ValueError("the model has no points in space")
            self._prepared[key] = prepare(part, self._params.spread)
        return self._prepared[key]


def _may_be_of_a_person(points_m: FloatArray) -> bool:
    least_m, most_m = EXTENTS_M
    off_m = np.abs(points_m - points_m.mean(axis=0)) if len(points_m) else np.zeros(1)
    return bool(least_m < off_m.max() < most_m)


def _with_others(rest: Labelling, is_other: BoolArray) -> Labelling:
    """Return the naming of all points, of which some are none of the model's."""
    n_points, n_outcomes = len(is_other), rest.masses.shape[1]
    masses = np.zeros((n_points, n_outcomes))
    masses[is_other, -1] = 1.0
    masses[~is_other] = rest.masses
    confidences = np.ones(n_points)
    confidences[~is_other] = rest.confidences
    names, guesses = iter(rest.names), iter(rest.guesses)
    others = is_other.tolist()
    return Labelling(
        tuple(None if other else next(names) for other in others),
        tuple(None if other else next(guesses) for other in others),
        confidences,
        rest.heading_rad,
        masses,
    )
