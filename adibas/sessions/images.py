"""Pictures and surfaces as bytes, and back without loss."""

import io
import zipfile

import numpy as np

from adibas.arrays import UInt8Array
from adibas.data.surface import BurstDisparity
from adibas.errors import StoreError

THUMBNAIL_SIDE_PX = 160
THUMBNAIL_QUALITY = 85
FAST = 1
"""The PNG compression that is written in a few tens of milliseconds."""


def encode_picture(picture_rgb: UInt8Array) -> bytes:
    """Return an (H, W, 3) picture as PNG."""
    import cv2

    return _encode(".png", picture_rgb, [cv2.IMWRITE_PNG_COMPRESSION, FAST])


def encode_thumbnail(picture_rgb: UInt8Array) -> bytes:
    """Return the picture with a longer side of 160 pixels as JPEG."""
    import cv2

    height, width = picture_rgb.shape[:2]
    share = min(1.0, THUMBNAIL_SIDE_PX / max(height, width))
    size = (max(1, round(width * share)), max(1, round(height * share)))
    small = cv2.resize(picture_rgb, size, interpolation=cv2.INTER_AREA)
    return _encode(
        ".jpg", np.asarray(small, np.uint8), [cv2.IMWRITE_JPEG_QUALITY, THUMBNAIL_QUALITY]
    )


def decode_picture(payload: bytes) -> UInt8Array:
    """Return the (H, W, 3) RGB picture in the bytes of a PNG or JPEG.

    Raises
    ------
    StoreError
        They are none.
    """
    import cv2

    data = np.frombuffer(payload, np.uint8)
    decoded = cv2.imdecode(data, cv2.IMREAD_COLOR) if payload else None
    if decoded is None:
        raise _damaged()
    return np.asarray(cv2.cvtColor(decoded, cv2.COLOR_BGR2RGB), np.uint8)


def encode_surface(surface: BurstDisparity) -> bytes:
    """Return the surface as a compressed .npz."""
    file = io.BytesIO()
    np.savez_compressed(
        file,
        mean_per_m=surface.mean_per_m,
        n_readings=surface.n_readings.astype(np.uint32),
        n_frames=np.int64(surface.n_frames),
    )
    return file.getvalue()


def decode_surface(payload: bytes) -> BurstDisparity:
    """Return the surface in the bytes of an .npz.

    Raises
    ------
    StoreError
        They are none.
    """
    try:
        with np.load(io.BytesIO(payload), allow_pickle=False) as arrays:
            return BurstDisparity(
                mean_per_m=arrays["mean_per_m"],
                n_readings=arrays["n_readings"].astype(np.int64),
                n_frames=int(arrays["n_frames"]),
            )
    except (ValueError, KeyError, OSError, EOFError, zipfile.BadZipFile) as error:
        raise _damaged() from error


def _encode(ending: str, picture_rgb: UInt8Array, options: list[int]) -> bytes:
    import cv2

    is_encoded, data = cv2.imencode(ending, cv2.cvtColor(picture_rgb, cv2.COLOR_RGB2BGR), options)
    if not is_encoded:
        raise ValueError(f"no picture: shape {picture_rgb.shape}")
    return data.tobytes()


def _damaged() -> StoreError:
    return StoreError(
        "A picture of the patient store is damaged. Restore the store's folder from a backup."
    )
