"""The last hundredths of a pixel: a blurred crossing of two edges fitted to the grey levels.

With d1, d2 the signed distances from the edges, E = erf(d / (sigma sqrt 2)) and D the way from
the corner, the model is ``(a + b T(E1 E2)) (1 + g . D)``: the crossing seen through a Gaussian
point spread of its own width across each edge, under the light g of the whole board, by a camera
whose tone curve ``T(E) = E + q (1 - E^2)`` makes white larger than black. An edge is an arc whose
curvature the neighbouring corners give, so that the lens does not move the crossing; the next
parallel edges stand where those corners are, so that small squares do not blur into it, nor does
a dot, a square of the same area in the model.
Any blur that is its own point reflection leaves the corner where it is.
Source: the saddle of thesis 4.18 with the point spread in place of the quadratic; the statistics
are those of least squares (Bjorck, Numerical Methods for Least Squares Problems, section 9.2).
"""

import math

import numpy as np

from adibas.arrays import FloatArray, UInt8Array
from adibas.data.board import MARK_RADIUS
from adibas.geometry.cholesky_kernels import factorise, solve_factorised
from adibas.kernels import compiled

N_UNKNOWNS = 9
P_U, P_V, P_FIRST, P_SECOND, P_BLUR1, P_BLUR2, P_MEAN, P_SWING, P_TONE = range(N_UNKNOWNS)
N_SHAPE = 16
"""Of a window: change of the pixel per column (u, v) and per row (u, v), curvature per pixel of the
edge along the row and of the one down the column, and the distances in pixels to the next edges
parallel to the first (below it, above it) and to the second (left, right), and 1 for each square
with a dot: above left, above right, below left, below right; relative change of the light per
pixel along u and v. Two unknowns for the light of each corner would cost half of its precision."""
BENDS, GAPS, DOTS, LIGHT = 4, 6, 10, 14
HALF_DOT = 0.5 * math.sqrt(math.pi) * MARK_RADIUS
FAR_BLURS = 4.0
WIDE_BLURS = 3.5
"""A window shows the edges out to so many standard deviations of the blur."""
NARROWEST_BAND_PX = 1.5
LEAST_PIXELS = 16
LEAST_BLUR_PX, MOST_BLUR = 0.25, 0.5
MOST_ROUNDS = 12
SMALL_STEP_PX = 1e-3
SQRT_HALF = math.sqrt(0.5)
SQRT_2_OVER_PI = math.sqrt(2.0 / math.pi)


@compiled
def edge(distance: float, blur: float) -> tuple[float, float]:
    """Return erf(d / (sigma sqrt 2)) and its derivative by d.

    Source: Abramowitz and Stegun, 7.1.26 (error below 1.5e-7).
    """
    x = abs(distance) / blur * SQRT_HALF
    bell = math.exp(-x * x)
    t = 1.0 / (1.0 + 0.3275911 * x)
    series = t * (
        0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429)))
    )
    value = 1.0 - series * bell
    return (value if distance >= 0.0 else -value), bell * SQRT_2_OVER_PI / blur


@compiled
def window_pixels(
    grey: UInt8Array, start: FloatArray, shape: FloatArray, limits: FloatArray, pixels: FloatArray
) -> int:
    """Fill `pixels` (M, 3) with u, v, grey of the pixels near the edges; return how many.

    `limits`: share of a square, pixels, and the band beside an edge in pixels. The window is its
    own point reflection, as the model is: what it lacks moves the corner the less.
    """
    area = shape[0] * shape[3] - shape[1] * shape[2]
    if area == 0.0:
        return 0
    radius = int(min(limits[1] + 1.0, limits[0] * (np.abs(shape[:4]).sum()) + 1.0))
    column, row = round(start[P_U]), round(start[P_V])
    n = 0
    for i in range(max(row - radius, 0), min(row + radius + 1, grey.shape[0])):
        for j in range(max(column - radius, 0), min(column + radius + 1, grey.shape[1])):
            right, down = j - start[P_U], i - start[P_V]
            if n < len(pixels) and _is_near(shape, area, limits, (right, down)):
                pixels[n, 0], pixels[n, 1], pixels[n, 2] = j, i, grey[i, j]
                n += 1
    return n


@compiled
def _is_near(
    shape: FloatArray, area: float, limits: FloatArray, offset: tuple[float, float]
) -> bool:
    right, down = offset
    if right * right + down * down > limits[1] * limits[1]:
        return False
    along = (right * shape[3] - down * shape[2]) / area
    across = (down * shape[0] - right * shape[1]) / area
    if max(abs(along), abs(across)) > limits[0]:
        return False
    height_along = abs(area) / math.hypot(shape[2], shape[3])
    height_across = abs(area) / math.hypot(shape[0], shape[1])
    return bool(min(abs(along) * height_along, abs(across) * height_across) <= limits[2])


@compiled
def edges(distance: float, blur: float, after: float, before: float) -> tuple[float, float, float]:
    """Return E of an edge and the next ones beside it, and its derivatives by d and blur."""
    value, slope = edge(distance, blur)
    by_blur = slope * distance
    if after - distance < FAR_BLURS * blur:
        other, other_slope = edge(distance - after, blur)
        value, slope = value - 1.0 - other, slope - other_slope
        by_blur -= other_slope * (distance - after)
    if distance + before < FAR_BLURS * blur:
        other, other_slope = edge(distance + before, blur)
        value, slope = value + 1.0 - other, slope - other_slope
        by_blur -= other_slope * (distance + before)
    return value, slope, -by_blur / blur


@compiled
def dot_cover(
    shape: FloatArray, distances: FloatArray, blurs: FloatArray, slopes: FloatArray
) -> float:
    """Return how much of a dot a pixel sees (0-1) that lies so far below and left of the edges.

    Fills `slopes` (2, 2): its derivatives by the distances, and by the blurs.
    """
    slopes[:] = 0.0
    quadrant = (2 if distances[0] > 0.0 else 0) + (0 if distances[1] > 0.0 else 1)
    if shape[DOTS + quadrant] == 0.0:
        return 0.0
    shares = np.empty(2)
    for k in range(2):
        gap = shape[GAPS + 2 * k + (0 if distances[k] > 0.0 else 1)]
        aside = abs(distances[k]) - 0.5 * gap
        first, first_slope = edge(HALF_DOT * gap + aside, blurs[k])
        second, second_slope = edge(HALF_DOT * gap - aside, blurs[k])
        shares[k] = 0.5 * (first + second)
        slopes[0, k] = 0.5 * (first_slope - second_slope) * (1.0 if distances[k] > 0.0 else -1.0)
        slopes[1, k] = (
            first_slope * (HALF_DOT * gap + aside) + second_slope * (HALF_DOT * gap - aside)
        ) * (-0.5 / blurs[k])
    for n in range(2):
        slopes[n, 0] *= shares[1]
        slopes[n, 1] *= shares[0]
    return float(shares[0] * shares[1])


@compiled
def checker(
    shape: FloatArray, distances: FloatArray, blurs: FloatArray, slopes: FloatArray
) -> float:
    """Return the blurred board, -1 to 1, so far from the edges; fill `slopes` as `dot_cover`."""
    cover = dot_cover(shape, distances, blurs, slopes)
    first, first_slope, first_by_blur = edges(distances[0], blurs[0], shape[GAPS], shape[GAPS + 1])
    second, second_slope, second_by_blur = edges(
        distances[1], blurs[1], shape[GAPS + 2], shape[GAPS + 3]
    )
    # The dot inverts what it covers.
    ground = 1.0 - 2.0 * cover
    for n in range(2):
        for k in range(2):
            slopes[n, k] *= -2.0 * first * second
    slopes[0, 0] += first_slope * second * ground
    slopes[0, 1] += second_slope * first * ground
    slopes[1, 0] += first_by_blur * second * ground
    slopes[1, 1] += second_by_blur * first * ground
    return float(first * second * ground)


@compiled
def _row(
    pixel: FloatArray,
    unknowns: FloatArray,
    trigonometry: FloatArray,
    shape: FloatArray,
    row: FloatArray,
) -> float:
    """Fill `row` (9,) with the model's derivatives at `pixel`; return measured minus model."""
    right, down = pixel[0] - unknowns[P_U], pixel[1] - unknowns[P_V]
    light = 1.0 + shape[LIGHT] * right + shape[LIGHT + 1] * down
    distances, slopes = np.empty(2), np.empty((2, 2))
    ways = np.empty((2, 3))
    for k in range(2):
        cosine, sine, bend = trigonometry[2 * k], trigonometry[2 * k + 1], shape[BENDS + k]
        along, across = cosine * right + sine * down, cosine * down - sine * right
        distances[k] = across - 0.5 * bend * along * along
        ways[k, 0] = sine + bend * along * cosine
        ways[k, 1] = -cosine + bend * along * sine
        ways[k, 2] = -along * (1.0 + bend * across)
    both = checker(shape, distances, unknowns[P_BLUR1 : P_BLUR2 + 1], slopes)
    # The swing is negative where E is that of the dark squares: white grows either way.
    tone = unknowns[P_TONE] if unknowns[P_SWING] > 0.0 else -unknowns[P_TONE]
    toned = both + tone * (1.0 - both * both)
    shade = unknowns[P_MEAN] + unknowns[P_SWING] * toned
    swing = light * unknowns[P_SWING] * (1.0 - 2.0 * tone * both)
    for axis in range(2):
        slope = slopes[0, 0] * ways[0, axis] + slopes[0, 1] * ways[1, axis]
        row[P_U + axis] = swing * slope - shade * shape[LIGHT + axis]
    for k in range(2):
        row[P_FIRST + k] = swing * slopes[0, k] * ways[k, 2]
        row[P_BLUR1 + k] = swing * slopes[1, k]
    row[P_MEAN], row[P_SWING] = light, light * toned
    row[P_TONE] = abs(light * unknowns[P_SWING]) * (1.0 - both * both)
    return float(pixel[2] - shade * light)


@compiled
def _normal_equations(
    pixels: FloatArray,
    unknowns: FloatArray,
    shape: FloatArray,
    normal: FloatArray,
    right: FloatArray,
) -> float:
    """Fill the lower triangle of the normal matrix and its right side; return the squared sum."""
    trigonometry = np.array(
        [
            math.cos(unknowns[P_FIRST]),
            math.sin(unknowns[P_FIRST]),
            math.cos(unknowns[P_SECOND]),
            math.sin(unknowns[P_SECOND]),
        ]
    )
    normal[:] = 0.0
    right[:] = 0.0
    total = 0.0
    row = np.empty(N_UNKNOWNS)
    for n in range(len(pixels)):
        left = _row(pixels[n], unknowns, trigonometry, shape, row)
        total += left * left
        for i in range(N_UNKNOWNS):
            right[i] += row[i] * left
            for j in range(i + 1):
                normal[i, j] += row[i] * row[j]
    return total


@compiled
def _step(
    normal: FloatArray, right: FloatArray, damping: float, unknowns: FloatArray, most_blur: float
) -> float:
    """Move `unknowns` by the damped step; return how far the corner went, NaN without a step."""
    damped = normal.copy()
    for i in range(N_UNKNOWNS):
        damped[i, i] += damping * normal[i, i] + 1e-12
    if not factorise(damped):
        return np.nan
    step = right.copy()
    solve_factorised(damped, step)
    unknowns += step
    for k in range(P_BLUR1, P_BLUR2 + 1):
        unknowns[k] = min(max(unknowns[k], LEAST_BLUR_PX), most_blur)
    return math.hypot(step[P_U], step[P_V])


@compiled
def fit_crossing(pixels: FloatArray, shape: FloatArray, unknowns: FloatArray) -> float:
    """Improve `unknowns` (9,) by Levenberg's method; return the sum of squares left, NaN if lost.

    Source: Nocedal and Wright, Numerical Optimization, section 10.3.
    """
    most_blur = MOST_BLUR * math.sqrt(abs(shape[0] * shape[3] - shape[1] * shape[2]))
    normal = np.empty((N_UNKNOWNS, N_UNKNOWNS))
    right = np.empty(N_UNKNOWNS)
    trial_normal, trial_right = normal.copy(), right.copy()
    total = _normal_equations(pixels, unknowns, shape, normal, right)
    damping = 1e-3
    for _ in range(MOST_ROUNDS):
        trial = unknowns.copy()
        moved = _step(normal, right, damping, trial, most_blur)
        if np.isnan(moved):
            return np.nan
        trial_total = _normal_equations(pixels, trial, shape, trial_normal, trial_right)
        if not trial_total <= total:
            if moved < SMALL_STEP_PX:
                break
            damping *= 10.0
            continue
        unknowns[:] = trial
        normal[:], right[:] = trial_normal, trial_right
        total, damping = trial_total, 0.1 * damping
        if moved < SMALL_STEP_PX:
            break
    return total


@compiled
def deviation_px(
    pixels: FloatArray, shape: FloatArray, unknowns: FloatArray, total: float
) -> float:
    """Return the standard deviation of u and v (root of their mean variance), NaN if unknown."""
    normal = np.empty((N_UNKNOWNS, N_UNKNOWNS))
    right = np.empty(N_UNKNOWNS)
    _normal_equations(pixels, unknowns, shape, normal, right)
    if not factorise(normal):
        return np.nan
    variance = 0.0
    for axis in range(2):
        right[:] = 0.0
        right[axis] = 1.0
        solve_factorised(normal, right)
        variance += 0.5 * right[axis]
    return math.sqrt(variance * total / (len(pixels) - N_UNKNOWNS))


@compiled
def fit_all(
    grey: UInt8Array, starts: FloatArray, shapes: FloatArray, limits: FloatArray
) -> FloatArray:
    """Fit N corners from `starts` (N, 9) in windows `shapes` (N, 16).

    Returns (N, 12): the unknowns, their standard deviation in pixels, the residual as a share of
    the swing, and the number of pixels; NaN where there is no fit. `limits`: share of a square,
    pixels, the band in blurs, the band in squares.
    """
    result = np.full((len(starts), N_UNKNOWNS + 3), np.nan)
    blurriest = starts[:, P_BLUR1 : P_BLUR2 + 1].max() if len(starts) else 0.0
    most = int(2.0 * max(limits[1], WIDE_BLURS * blurriest) + 3.0)
    pixels = np.empty((most * most, 3))
    window = np.empty(3)
    for n in range(len(starts)):
        unknowns, shape = starts[n].copy(), shapes[n]
        width = math.sqrt(abs(shape[0] * shape[3] - shape[1] * shape[2]))
        blur = max(unknowns[P_BLUR1], unknowns[P_BLUR2])
        band = min(limits[2] * blur, limits[3] * width)
        window[0], window[2] = limits[0], max(band, NARROWEST_BAND_PX)
        window[1] = max(limits[1], WIDE_BLURS * blur)
        n_pixels = window_pixels(grey, unknowns, shape, window, pixels)
        if n_pixels < LEAST_PIXELS:
            continue
        total = fit_crossing(pixels[:n_pixels], shape, unknowns)
        if np.isnan(total):
            continue
        result[n, :N_UNKNOWNS] = unknowns
        result[n, N_UNKNOWNS] = deviation_px(pixels[:n_pixels], shape, unknowns, total)
        result[n, N_UNKNOWNS + 1] = math.sqrt(total / n_pixels) / max(abs(unknowns[P_SWING]), 1e-9)
        result[n, N_UNKNOWNS + 2] = n_pixels
    return result
