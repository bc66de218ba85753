"""Backs in closed form: a profile, a line aside and a surface that turns, all known exactly."""

import numpy as np

TOP_M, BOTTOM_M = 1.50, 0.86
STATURE_M = 1.70
SWING_M = 0.02
WAVE_M = 0.44
CROSSING_M = 1.12
"""Height of the thoracolumbar inflection: 0.66 of the stature."""


def profile_m(y_m):
    """A sine: apices a quarter of a wave above and below the inflection, inflections at a half."""
    return SWING_M * np.sin(2 * np.pi * (y_m - CROSSING_M) / WAVE_M)


STEEPEST_RAD = np.arctan(SWING_M * 2 * np.pi / WAVE_M)


def line_m(y_m):
    return 0.012 * np.sin(2 * np.pi * (y_m - 0.9) / 0.6)


def back_points(rng=None, noise_m=0.0, rotation_rad=0.0, step_m=0.003):
    """Points of a trunk with a furrow, flat in the middle and round at the flanks."""
    x_m, y_m = np.meshgrid(np.arange(-0.16, 0.16, step_m), np.arange(BOTTOM_M, TOP_M, step_m))
    aside_m = x_m - line_m(y_m)
    furrow_m = -0.006 * np.exp(-((aside_m / 0.02) ** 2)) - 25.0 * aside_m**4 - 1.0 * aside_m**2
    furrow_m += 0.006
    z_m = profile_m(y_m) + furrow_m + np.tan(rotation_rad) * aside_m
    if rng is not None:
        z_m = z_m + rng.normal(0.0, noise_m, z_m.shape)
    return np.stack([x_m.ravel(), y_m.ravel(), z_m.ravel()], axis=1)
