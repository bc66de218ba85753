"""From true depth to what a Kinect v1 or PrimeSense reports.

The device matches an infrared dot pattern over a window of 9 x 7 pixels and reports disparity in
steps of 1/8 pixel. So its noise is made in disparity, where it is constant and correlated over
that window; rounded there, and turned into whole millimetres as OpenNI gives them.
``docs/simulation.md`` lists every value with its source.
"""

import math
from dataclasses import dataclass
from typing import TypeVar

import cv2
import numpy as np
import numpy.typing as npt
from scipy.special import ndtr

from adibas.arrays import Float32Array, FloatArray, UInt16Array
from adibas.simulation.depth_kernels import Int8Array, NoiseFields, Numbers, find_lit, measure
from adibas.simulation.device import Device

Scalar = TypeVar("Scalar", bound=np.generic)

SUBPIXELS = 8.0
_BANK_MARGIN_PX = 256
_BLOB_SD_PX = 1.0


@dataclass(frozen=True, slots=True)
class DepthNoise:
    """How bad the depth is; the defaults are the published values.

    Attributes
    ----------
    projector_baseline_m : float
        Between projector and depth camera: 75 mm (Konolige & Mihelich).
    window_px : (width, height)
        Of correlation: 9 x 7 (Konolige & Mihelich).
    disparity_sd : float
        Of the noise that changes from frame to frame, raw units of 1/8 pixel: 0.5
        (Khoshelham & Elberink 2012).
    temporal_weights : tuple of float
        Share of this and earlier moments' noise in one frame, before it is scaled to
        `disparity_sd` (assumed; gives a correlation of 0.30 with the frame before).
    static_sd : float
        Of the fixed pattern, raw units (assumed: about 2 mm at 2 m, "a few mm" in Boehm 2014).
    edge_jitter_px : float
        Standard deviation of where an edge is seen: 0.8 (Nguyen et al. 2012).
    edge_step_m : float
        Difference of neighbours that makes an edge (assumed).
    edge_dropout : float
        Probability that a pixel beside an edge has no depth (assumed).
    grazing_rad : (float, float)
        Angle to the surface's normal where depth begins to fail, and where none is left
        (75 and 83 degrees; assumed, drop-outs "over 60-70" in PEERS 3.4).
    random_dropout : float
        Probability of no depth for no reason (assumed).
    dark_echo, dim_echo : float
        Infrared echo (reflectance x cosine / z^2) under which no depth is found, and over which
        all is (assumed: black hair begins to be lost at 2 m, bare skin at the end of the range).
    range_m : (float, float)
        0.5 to 4.5 m.
    border_px : int
        Columns at the left without depth (8: half a window and more).
    flying_share : float
        Of the pixels beside an edge that show a depth between the two sides; off by default.
    """

    projector_baseline_m: float = 0.075
    window_px: tuple[int, int] = (9, 7)
    disparity_sd: float = 0.5
    temporal_weights: tuple[float, ...] = (1.0, 0.3, 0.1)
    static_sd: float = 0.15
    edge_jitter_px: float = 0.8
    edge_step_m: float = 0.05
    edge_dropout: float = 0.25
    grazing_rad: tuple[float, float] = (math.radians(75.0), math.radians(83.0))
    random_dropout: float = 0.001
    dark_echo: float = 0.003
    dim_echo: float = 0.012
    range_m: tuple[float, float] = (0.5, 4.5)
    border_px: int = 8
    flying_share: float = 0.0


EXACT = DepthNoise(
    disparity_sd=0.0,
    static_sd=0.0,
    edge_jitter_px=0.0,
    edge_dropout=0.0,
    random_dropout=0.0,
    dark_echo=-1.0,
    dim_echo=0.0,
)
"""Only what geometry and rounding do: shadow, grazing angles, range and steps of disparity."""


class DepthSensor:
    """The depth camera of one device: true images in, raw images out.

    Moments may be asked for in any order; the same moment always gives the same noise.

    Parameters
    ----------
    device : Device
        Its seed decides the fixed pattern.
    noise : DepthNoise
        How much of each disturbance.
    seed : int
        Of everything that changes from frame to frame.
    """

    def __init__(self, device: Device, noise: DepthNoise, seed: int) -> None:
        self._noise = noise
        self._seed = seed
        self._camera = device.depth
        self._numbers = _numbers(device, noise)
        self._bias_c = device.calibration.depth_bias.square_term_per_m(device.depth)
        self._static = noise.static_sd * self._unit_field((device.seed, 0xF1))
        bank = np.random.default_rng([seed, 0xBA])
        self._jitter = [_whole(noise.edge_jitter_px * self._blobs(bank)) for _ in range(2)]
        self._luck = ndtr(self._blobs(bank)).astype(np.float32)
        self._recent: dict[int, Float32Array] = {}

    def measure(
        self,
        inverse_depth: Float32Array,
        reflectance: Float32Array,
        moment: int,
        holes_px: FloatArray | None = None,
    ) -> UInt16Array:
        """Return the (H, W) uint16 depth in millimetres, 0 = no reading.

        Parameters
        ----------
        inverse_depth : (H, W) float32 array
            True 1/z, 1/metres; 0 where nothing is.
        reflectance : (H, W) float32 array
            Of the surfaces in infrared, 0 to 1.
        moment : int
            Number of the frame, from 0.
        holes_px : (N, 3) array or None
            u, v and radius of places that reflect no pattern.
        """
        lit = np.empty(inverse_depth.shape, np.bool_)
        focal_px = self._camera.intrinsics.fx
        find_lit(
            inverse_depth,
            focal_px * self._noise.projector_baseline_m,
            lit,
            np.empty(2 * self._camera.width, np.float32),
        )
        depth_mm = np.zeros(inverse_depth.shape, np.uint16)
        fields = self._fields(moment)
        measure(inverse_depth, reflectance, lit, fields, self._numbers, depth_mm)
        depth_mm[:, : self._noise.border_px] = 0
        for u, v, radius in () if holes_px is None else holes_px:
            _punch(depth_mm, u, v, radius)
        return depth_mm

    def _fields(self, moment: int) -> NoiseFields:
        weights = np.array(self._noise.temporal_weights)
        weights *= self._noise.disparity_sd / np.sqrt((weights**2).sum())
        wanted = range(moment, moment - len(weights), -1)
        # A dictionary of its own: frames may be asked for by several threads.
        fields = {m: self._moment(m) for m in wanted}
        self._recent = fields
        disparity = self._static.copy()
        for m, weight in zip(wanted, weights.astype(np.float32), strict=True):
            cv2.scaleAdd(fields[m], float(weight), disparity, dst=disparity)
        rng = np.random.default_rng([self._seed, 0x0F, moment + 16])
        jitter_u, jitter_v = (self._cut(bank, rng) for bank in self._jitter)
        luck = self._cut(self._luck, rng)
        return NoiseFields(disparity, jitter_u, jitter_v, luck, self._bias_c)

    def _moment(self, moment: int) -> Float32Array:
        known = self._recent.get(moment)
        return self._unit_field((self._seed, 0x4E, moment + 16)) if known is None else known

    def _unit_field(self, key: tuple[int, ...]) -> Float32Array:
        """Return noise of standard deviation 1, averaged over the window of correlation."""
        across, down = self._noise.window_px
        rng = np.random.Generator(np.random.SFC64(list(key)))
        shape = (self._camera.height + down, self._camera.width + across)
        white = rng.standard_normal(shape, np.float32)
        mean = cv2.blur(white, (across, down))
        rows, columns = down // 2, across // 2
        inner = mean[rows : rows + self._camera.height, columns : columns + self._camera.width]
        field: Float32Array = inner * np.float32(np.sqrt(across * down))
        return field

    def _blobs(self, rng: np.random.Generator) -> Float32Array:
        """Return noise of standard deviation 1, larger than the image, in blobs of some pixels."""
        shape = (self._camera.height + _BANK_MARGIN_PX, self._camera.width + _BANK_MARGIN_PX)
        smooth = cv2.GaussianBlur(rng.standard_normal(shape, np.float32), (0, 0), _BLOB_SD_PX)
        blobs: Float32Array = smooth / smooth.std()
        return blobs

    def _cut(self, bank: npt.NDArray[Scalar], rng: np.random.Generator) -> npt.NDArray[Scalar]:
        v, u = rng.integers(0, _BANK_MARGIN_PX, 2)
        return bank[v : v + self._camera.height, u : u + self._camera.width]


def _numbers(device: Device, noise: DepthNoise) -> Numbers:
    k, bias = device.depth.intrinsics, device.calibration.depth_bias
    begin, end = (math.cos(angle) for angle in noise.grazing_rad)
    return Numbers(
        focal_px=k.fx,
        pixel_rad=1.0 / k.fx,
        cx=k.cx,
        cy=k.cy,
        bias_a=bias.a,
        bias_b=bias.b,
        disparity_factor=SUBPIXELS * noise.projector_baseline_m * k.fx,
        disparity_offset=device.disparity_offset,
        edge_step_m=noise.edge_step_m,
        edge_dropout=noise.edge_dropout,
        random_dropout=noise.random_dropout,
        flying_share=noise.flying_share,
        grazing_begin_cos=begin,
        grazing_slope=1.0 / (begin - end),
        dim_echo=noise.dim_echo,
        dark_slope=1.0 / (noise.dim_echo - noise.dark_echo),
        nearest_m=noise.range_m[0],
        farthest_m=noise.range_m[1],
    )


def _whole(jitter_px: Float32Array) -> Int8Array:
    return np.clip(np.rint(jitter_px), -127, 127).astype(np.int8)


def _punch(depth_mm: UInt16Array, u: float, v: float, radius: float) -> None:
    """Take out a disc."""
    height, width = depth_mm.shape
    top, bottom = max(int(v - radius), 0), min(int(v + radius) + 2, height)
    left, right = max(int(u - radius), 0), min(int(u + radius) + 2, width)
    if top >= bottom or left >= right:
        return
    rows, columns = np.ogrid[top:bottom, left:right]
    inside = (rows - v) ** 2 + (columns - u) ** 2 <= radius**2
    depth_mm[top:bottom, left:right][inside] = 0
