"""The one way to compile a hot loop: numba, cached in the user's cache folder."""

import os
from collections.abc import Callable
from typing import Any, TypeVar, cast

import platformdirs

os.environ.setdefault("NUMBA_CACHE_DIR", str(platformdirs.user_cache_path("adibas") / "numba"))

import numba

Function = TypeVar("Function", bound=Callable[..., Any])

parallel_range = numba.prange


def compiled(function: Function) -> Function:
    """Compile `function` when first called; keep the machine code for the next start."""
    return cast(Function, numba.njit(cache=True, nogil=True)(function))


def compiled_parallel(function: Function) -> Function:
    """Like `compiled`, with `parallel_range` spread over the cores."""
    return cast(Function, numba.njit(cache=True, nogil=True, parallel=True)(function))
