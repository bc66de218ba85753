"""Figures as pictures, for workbooks."""

import io

import numpy as np
from matplotlib.figure import Figure

from adibas.arrays import UInt8Array

DOTS_PER_INCH = 130


def picture_of(figure: Figure) -> UInt8Array:
    """Return a figure as (H, W, 3) pixels."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    FigureCanvasAgg(figure)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=DOTS_PER_INCH)
    picture: UInt8Array = np.array(Image.open(file).convert("RGB"))
    return picture
