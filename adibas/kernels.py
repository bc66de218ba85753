"""The one way to compile a hot loop: numba, cached in the user's cache folder."""

import logging
import os
import threading
from collections.abc import Callable
from typing import Any, TypeVar, cast

import platformdirs

from adibas.shipped_kernels import build_mark, look_among_shipped, use_shipped_kernels

os.environ.setdefault("NUMBA_CACHE_DIR", str(platformdirs.user_cache_path("adibas") / "numba"))
os.environ.setdefault("GOMP_SPINCOUNT", "1000")
"""How often a thread looks for the next parallel loop before it sleeps.

The usual 300,000 times keep a core busy that window and sensor want: a quarter of the live chain's
CPU time, and it is no faster for it.
"""
use_shipped_kernels()

import numba  # noqa: E402  (it reads all that only now)
from numba.core.registry import CPUDispatcher  # noqa: E402
from numba.np.ufunc.parallel import threading_layer  # noqa: E402

from adibas.kernel_sources import sources_of  # noqa: E402  (numpy, as numba)

logger = logging.getLogger(__name__)

Function = TypeVar("Function", bound=Callable[..., Any])

parallel_range = numba.prange
_one_loop_at_a_time = threading.Lock()


def compiled(function: Function) -> Function:
    """Compile `function` when first called; keep the machine code for the next start."""
    return cast(Function, _forgiving(numba.njit(cache=True, nogil=True)(function)))


def compiled_parallel(function: Function) -> Function:
    """Like `compiled`, with `parallel_range` spread over the cores; to be called from Python."""
    dispatcher = cast(Any, numba.njit(cache=True, nogil=True, parallel=True)(function))
    dispatcher.__class__ = _InTurn  # numba lets nobody say of which class it is to be
    return cast(Function, _forgiving(dispatcher))


def compiled_fused(function: Function) -> Function:
    """Like `compiled`; a product and a sum may become one instruction, rounded once.

    The result may differ in the last digit between processors, and only there.
    """
    return cast(
        Function, _forgiving(numba.njit(cache=True, nogil=True, fastmath={"contract"})(function))
    )


def wake_compiler() -> None:
    """Let numba load what it needs at its first call, a quarter of a second, before somebody waits.

    Compiled functions that the cache has are loaded in milliseconds then.
    """
    cast(Callable[[], None], numba.njit(_nothing))()


class _InTurn(CPUDispatcher):
    """A parallel loop that waits for its turn where numba's own threads do the work.

    Where neither OpenMP's library nor TBB's is there, numba ends the whole program as soon as two
    threads are in parallel loops at once.
    """

    def __call__(self, *arguments: object) -> object:
        if _are_loops_independent():
            return super().__call__(*arguments)
        with _one_loop_at_a_time:
            return super().__call__(*arguments)


def _are_loops_independent() -> bool:
    """Say whether several threads may be in parallel loops; known after the first loop."""
    try:
        return cast(Callable[[], str], threading_layer)() != "workqueue"
    except ValueError:  # no parallel loop was started yet
        return False


def _nothing() -> None:
    """Be compiled."""


def _forgiving(dispatcher: Any) -> Any:
    """Let a cache that cannot be written cost the next start time, and this one nothing.

    numba lets the error of a full disk through to whoever called the compiled function.
    """
    cache = dispatcher._cache  # noqa: SLF001  (numba offers no other place)
    _watch_sources(dispatcher.py_func, cache)
    look_among_shipped(dispatcher)
    save = cache.save_overload

    def save_if_possible(signature: object, code: object) -> None:
        try:
            save(signature, code)
        except OSError as error:
            logger.info("the compiler's cache cannot be written: %s", error.strerror)

    cache.save_overload = save_if_possible
    return dispatcher


def _watch_sources(function: Callable[..., Any], cache: Any) -> None:
    """Let kept machine code count as long as all stays as it was that went into it."""
    if build_mark() is not None:
        return
    load = cache.load_overload

    def load_if_nothing_changed(signature: object, context: object) -> object:
        cache._cache_file._source_stamp = sources_of(function)  # noqa: SLF001  (as above)
        return load(signature, context)

    cache.load_overload = load_if_nothing_changed
