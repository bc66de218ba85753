"""Inflections, apices and angles of the sagittal profile of the back.

Source: Appraisal of the DIERS method for calculating postural measurements, doi
10.1186/s13013-017-0134-y, table 1, for the points ICT, KA, ITL, LA and ILS; doi
10.1186/1471-2474-13-151, figure 3, for the angles between the inflectional tangents; doi
10.1155/2014/638238, figure 5, for the fleches.
"""

from dataclasses import dataclass

import numpy as np

from adibas.arrays import BoolArray, FloatArray
from adibas.surface.spine_profile import SpineProfile

Z_95 = 1.959964


@dataclass(frozen=True, slots=True)
class SagittalParams:
    """Where the points are looked for, as shares of the stature.

    Attributes
    ----------
    thoracolumbar : (low, high)
        Of the inflection ITL: 0.58 to 0.78. Trunk lengths VP-DM of 404 to 500 mm about a C7 at
        0.82 to 0.85 of the stature put it between.
    lowest : float
        Of the inflection ILS: 0.53, the upper end of the natal cleft.
    shape_sds : (kyphosis, lordosis, fleche cervicale, fleche lombaire)
        Radians and metres; counted with the noise: 0.8 degrees, 1.9 and 1.2 mm. Without noise
        the fitted profile differs from the skin over the spinous processes by 1.2 and 1.0
        degrees, 1.9 and 1.2 mm (root mean square of 16 simulated bodies with bent spines), some
        of which the fit's own scatter counts already.
    n_draws, seed : int
        Of the profiles that are drawn to see what noise does.
    """

    thoracolumbar: tuple[float, float] = (0.58, 0.78)
    lowest: float = 0.53
    shape_sds: tuple[float, float, float, float] = (0.014, 0.014, 0.0019, 0.0012)
    n_draws: int = 100
    seed: int = 0


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value and its standard deviation, as far as the instrument goes."""

    value: float
    sd: float

    @property
    def interval(self) -> tuple[float, float]:
        """95 % of a normal error."""
        return self.value - Z_95 * self.sd, self.value + Z_95 * self.sd


@dataclass(frozen=True, slots=True)
class SagittalShape:
    """Heights of the points, metres over the floor, and what is measured between them.

    Attributes
    ----------
    ict_m, ka_m, itl_m, la_m, ils_m : float
        Cervicothoracic inflection, kyphotic apex, thoracolumbar inflection, lordotic apex,
        lumbosacral inflection.
    cervical_m : float
        The foremost place of the neck above ICT.
    kyphosis_rad, lordosis_rad : Estimate
    fleche_cervicale_m, fleche_lombaire_m : Estimate
    """

    ict_m: float
    ka_m: float
    itl_m: float
    la_m: float
    ils_m: float
    cervical_m: float
    kyphosis_rad: Estimate
    lordosis_rad: Estimate
    fleche_cervicale_m: Estimate
    fleche_lombaire_m: Estimate

    @property
    def places(self) -> tuple[tuple[str, float, bool], ...]:
        """Name, height in metres, and whether it is a turn and no apex; from the top down."""
        return (
            ("ICT", self.ict_m, True),
            ("KA", self.ka_m, False),
            ("ITL", self.itl_m, True),
            ("LA", self.la_m, False),
            ("ILS", self.ils_m, True),
        )


def sagittal_shape(
    profile: SpineProfile, stature_m: float, params: SagittalParams | None = None
) -> SagittalShape | None:
    """Find the points; None where the profile ends before one of them.

    Noise makes extremes more extreme. What it adds is found by drawing profiles with that much
    more noise (parametric bootstrap), and taken off.
    """
    params = params or SagittalParams()
    y_m = profile.heights_m()
    slope, back_m = profile.inclination(y_m), profile.back_m(y_m)
    places = _places(y_m, slope, back_m, stature_m, params)
    if places is None:
        return None
    values = _values(places, slope, back_m)
    rng = np.random.default_rng(params.seed)
    noise = np.linalg.cholesky(profile.covariance + 1e-15 * np.eye(len(profile.covariance)))
    drawn = noise @ rng.normal(size=(len(noise), params.n_draws))
    slopes = slope[:, None] + profile.weights(y_m, 1) @ drawn
    backs_m = back_m[:, None] + profile.weights(y_m) @ drawn
    draws = []
    for some_slope, some_back_m in zip(slopes.T, backs_m.T, strict=True):
        others = _places(y_m, some_slope, some_back_m, stature_m, params)
        if others is not None:
            draws.append(_values(others, some_slope, some_back_m))
    if len(draws) <= params.n_draws // 2:
        return None
    biases = np.mean(draws, axis=0) - values
    sds = np.hypot(np.std(draws, axis=0), params.shape_sds)
    ict_m, ka_m, itl_m, la_m, ils_m, cervical_m = (float(y_m[place]) for place in places)
    kyphosis, lordosis, cervicale, lombaire = (
        Estimate(float(value - bias), float(sd))
        for value, bias, sd in zip(values, biases, sds, strict=True)
    )
    return SagittalShape(
        *(ict_m, ka_m, itl_m, la_m, ils_m, cervical_m), kyphosis, lordosis, cervicale, lombaire
    )


def _places(
    y_m: FloatArray,
    slope: FloatArray,
    back_m: FloatArray,
    stature_m: float,
    params: SagittalParams,
) -> tuple[int, ...] | None:
    """Return the rows of ICT, KA, ITL, LA, ILS and the neck's foremost place."""
    low, high = (share * stature_m for share in params.thoracolumbar)
    itl = _highest_peak(slope, (y_m >= low) & (y_m <= high))
    if itl is None:
        return None
    ict = _extreme(-slope, y_m > y_m[itl])
    ils = _extreme(-slope, (y_m < y_m[itl]) & (y_m >= params.lowest * stature_m))
    if ict is None or ils is None:
        return None
    ka = ict + int(back_m[ict : itl + 1].argmax())
    la = itl + int(back_m[itl : ils + 1].argmin())
    return ict, ka, itl, la, ils, int(back_m[: ict + 1].argmin())


def _values(places: tuple[int, ...], slope: FloatArray, back_m: FloatArray) -> FloatArray:
    """Return kyphosis and lordosis, radians, and both fleches, metres."""
    ict, ka, itl, la, ils, cervical = places
    at_ict, at_itl, at_ils = np.arctan(slope[[ict, itl, ils]])
    return np.array(
        [
            at_itl - at_ict,
            at_itl - at_ils,
            back_m[ka] - back_m[cervical],
            back_m[ka] - back_m[la],
        ]
    )


def _extreme(values: FloatArray, allowed: BoolArray) -> int | None:
    """Return where the allowed values are greatest; None where that is only at their border."""
    places = np.flatnonzero(allowed)
    if len(places) < 3:  # noqa: PLR2004  (an extreme has two neighbours)
        return None
    best = int(places[values[places].argmax()])
    return None if best in (0, len(values) - 1) else best


def _highest_peak(values: FloatArray, allowed: BoolArray) -> int | None:
    """Return the highest of the allowed peaks; None where there is none.

    The border of what is allowed is no peak: towards the seat the slope rises again, beyond that of
    a flat back's inflection, without a turn between.
    """
    peaks = 1 + np.flatnonzero((values[1:-1] >= values[:-2]) & (values[1:-1] > values[2:]))
    peaks = peaks[allowed[peaks]]
    return int(peaks[values[peaks].argmax()]) if len(peaks) else None
