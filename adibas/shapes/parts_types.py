"""What the kernels that name points by parts take: a core that hardly bends, and limbs at it.

The core (head, neck, shoulders, trunk, hips) is a mixture of normal distributions for each kind of
posture. A limb is two points, one beyond the other, whose places depend on the core's shape: again
a mixture for each kind. Everything is in metres with y down, the core turned about y onto its mean.
"""

from typing import NamedTuple

from adibas.arrays import FloatArray, IntArray


class Core(NamedTuple):
    """The core of C points; K components.

    Attributes
    ----------
    labels, mirror : (C,) int arrays
        Which label each point is; index in the core of its mirror image.
    mean : (C, 3) array
        Of all shapes, centred, metres: cores are turned onto it.
    basis : (B, 3 C) array
        Gives what limbs depend on, from a core of size 1 less `basis_mean`.
    basis_mean : (C, 3) array
    log_weights, kinds : (K,) arrays
        Of the components; to which kind of posture each belongs.
    means, covariances, factors : (K, C, 3) and (K, 3 C, 3 C) arrays
        With shifts and small turns among what varies; lower Cholesky factors.
    """

    labels: IntArray
    mirror: IntArray
    mean: FloatArray
    basis: FloatArray
    basis_mean: FloatArray
    log_weights: FloatArray
    kinds: IntArray
    means: FloatArray
    covariances: FloatArray
    factors: FloatArray


class Limbs(NamedTuple):
    """L limbs of two points, K components each (of the fewer, the rest have no weight).

    Attributes
    ----------
    labels : (L, 2) int array
        Inner and outer point.
    roots : (L,) int array
        Index in the core of where the limb begins.
    signs : (L,) array
        1, or -1 where x is mirrored: the right limb is the left one's mirror image.
    kinds, log_weights : (L, K) arrays
    core_means, core_factors : (L, K, B) and (L, K, B, B) arrays
        Of the core's numbers.
    means, slopes, factors : (L, K, 6), (L, K, 6, B) and (L, K, 6, 6) arrays
        Of both points from the root, in sizes of the core, where the core's numbers are known.
    outer_factors : (L, K, 3, 3) array
        Of the outer point alone.
    bone_means, bone_covariances : (L, Q, 2) and (L, Q, 2, 2) arrays
        Of the logarithms of both bones' lengths in sizes of the core, for each kind of posture.
    side_covariances : (L, Q, 2, 2) array
        Of these with the other side's.
    drawn_means, drawn_covariances : (L, Q, 2) and (L, Q, 2, 2) arrays
        Of the lengths that the components alone let expect.
    strange : (L,) array
        How often bones are as the components alone say, whatever their lengths: 1, always.
    """

    labels: IntArray
    roots: IntArray
    signs: FloatArray
    kinds: IntArray
    log_weights: FloatArray
    core_means: FloatArray
    core_factors: FloatArray
    means: FloatArray
    slopes: FloatArray
    factors: FloatArray
    outer_factors: FloatArray
    bone_means: FloatArray
    bone_covariances: FloatArray
    side_covariances: FloatArray
    drawn_means: FloatArray
    drawn_covariances: FloatArray
    strange: FloatArray


class Anchors(NamedTuple):
    """How the core lies about one of its points; A components, each with P points to begin at.

    Attributes
    ----------
    costs : (A,) array
        Minus the log weights.
    means : (A, C, 3) array
    points : (P,) int array
        Indices in the core.
    whiteners : (A, P, C, 3, 3) array
        Lower triangular: they make the way from the anchor to another point a unit normal one.
    constants : (A, P, C) array
        Log density of that way at its mean.
    """

    costs: FloatArray
    means: FloatArray
    points: IntArray
    whiteners: FloatArray
    constants: FloatArray


class Odds(NamedTuple):
    """What is expected of a set of points before they are looked at.

    Attributes
    ----------
    n_kinds : int
    log_room : float
        Log volume in which a point may be that has no label.
    counts, least_counts : (N + 1,) arrays
        Minus the log probability of so many labels without a point, and as many points without a
        label as there are then; the least of so many or more.
    lone : float
        About what one label without a point costs.
    kappa, heading_rad : float
        Concentration about the declared heading; NaN: none was declared.
    gap : float
        Energies farther above the lowest do not count.
    side_divisor : float
        Of energies of a patient who faces the other way, where no heading was declared.
    mixed : (L,) array
        How often a limb is as in any kind of posture, whatever the rest of the body does.
    label_odds : (M, N) array
        Log odds of each label for each point by what is known of it beside the places.
    n_judged, n_varied : int
        Cores that get limbs, and of these, cores whose neighbours get limbs: more of them, up to
        twice as many, as long as a neighbour is the best so far.
    too_unlikely : float
        A core that is less likely than the best one by so many nats is not judged.
    """

    n_kinds: int
    log_room: float
    counts: FloatArray
    least_counts: FloatArray
    lone: float
    kappa: float
    heading_rad: float
    gap: float
    side_divisor: float
    mixed: FloatArray
    label_odds: FloatArray
    n_judged: int
    n_varied: int
    too_unlikely: float


class Pool(NamedTuple):
    """Ways to name points: energies, headings (P,), partners (P, N); the first `n_filled` (1,)."""

    energies: FloatArray
    headings: FloatArray
    partners: IntArray
    n_filled: IntArray
