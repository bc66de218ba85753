"""How strongly neighbouring pixels hold together, from what a camera sees of them.

Source: thesis, equation 6.23: ``exp(-beta |x_i - x_j|^2) / dist(i, j)`` with
``beta = 1 / (2 <|x_i - x_j|^2>)``; the mean is over the pairs of the mask alone.
"""

import numpy as np

from adibas.arrays import Float32Array, FloatArray, UInt8Array, check_shape
from adibas.graphcut.boundary_kernels import mean_square_step, weigh
from adibas.graphcut.neighbors import PixelGraph

_COLOR_RANGE = 255.0


def boundary_weights(graph: PixelGraph, picture: FloatArray | Float32Array) -> FloatArray:
    """Return the weight of each pair of neighbours: 1 where they look the same.

    Parameters
    ----------
    graph : PixelGraph
        Of the mask, N pixels with K arcs each.
    picture : array of the graph's shape, or of that and C channels
        Depth, colour or both (`depth_and_color`), in any unit. NaN: a pair of which one is not
        measured holds as an average pair.

    Returns
    -------
    weights : (N, K) array
        The same in both directions; 0 where there is no neighbour.
    """
    if picture.shape[: len(graph.shape)] != graph.shape:
        raise ValueError(f"the picture must have shape {graph.shape}, got {picture.shape}")
    values = picture.reshape(int(np.prod(graph.shape)), -1)[graph.pixels].astype(np.float64)
    beta_square = mean_square_step(graph.neighbors, values)
    return weigh(graph.neighbors, values, beta_square, graph.distances)


def depth_and_color(depth_m: FloatArray | Float32Array, color_rgb: UInt8Array) -> FloatArray:
    """Return depth, spread over 0 to 255, beside red, green and blue.

    Parameters
    ----------
    depth_m : (..., H, W) array
        NaN where not measured, and outside the mask: its range is what is spread.
    color_rgb : (..., H, W, 3) array
        Registered to the depth.
    """
    check_shape("color_rgb", color_rgb, (*depth_m.shape, 3))
    if np.isnan(depth_m).all():
        spread = np.full(depth_m.shape, np.nan)
    else:
        low, high = float(np.nanmin(depth_m)), float(np.nanmax(depth_m))
        spread = (depth_m - low) * (_COLOR_RANGE / max(high - low, np.finfo(float).tiny))
    return np.concatenate([spread[..., None], color_rgb], axis=-1)
