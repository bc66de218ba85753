"""Array aliases, and the checks of shape that every stage shares.

Nothing of NumPy is needed for them while the program runs: the window starts without it.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    AnyArray: TypeAlias = npt.NDArray[Any]
    FloatArray: TypeAlias = npt.NDArray[np.float64]
    Float32Array: TypeAlias = npt.NDArray[np.float32]
    UInt8Array: TypeAlias = npt.NDArray[np.uint8]
    UInt16Array: TypeAlias = npt.NDArray[np.uint16]
    Int32Array: TypeAlias = npt.NDArray[np.int32]
    IntArray: TypeAlias = npt.NDArray[np.int64]
    BoolArray: TypeAlias = npt.NDArray[np.bool_]
else:
    AnyArray = FloatArray = Float32Array = UInt8Array = UInt16Array = Any
    Int32Array = IntArray = BoolArray = Any


def check_shape(name: str, array: AnyArray, shape: Sequence[int | None]) -> None:
    """Raise ValueError unless `array` has `shape`; None stands for any length."""
    fits = array.ndim == len(shape) and all(
        want in (None, got) for want, got in zip(shape, array.shape, strict=True)
    )
    if not fits:
        wanted = ", ".join("?" if length is None else str(length) for length in shape)
        raise ValueError(f"{name} must have shape ({wanted}), got {array.shape}")


def read_only(array: AnyArray) -> None:
    """Make `array` read-only in place, so that threads can share it."""
    array.flags.writeable = False
