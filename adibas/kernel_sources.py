"""What machine code was made from: the sources of a compiled function and of all that it calls.

numba keeps machine code until the file of the function itself changes. What is called, and the
numbers of other modules, are part of that code, too: after an update that changed them alone, the
old code would go on running.
"""

from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

import numpy as np

Function = Callable[..., Any]


@cache
def sources_of(function: Function) -> tuple[str, ...]:
    """Return marks of every file whose compiled functions go into this one, and of numbers used.

    To be asked when all modules are imported: functions that are defined further down count, too.
    """
    marks: set[str] = set()
    waiting, seen = [function], {function}
    while waiting:
        one = waiting.pop()
        facts = Path(one.__code__.co_filename).stat()
        marks.add(f"{one.__module__} {facts.st_mtime_ns} {facts.st_size}")
        for name, value in _used(one):
            called = getattr(value, "py_func", None)
            if called is None:
                marks.add(f"{one.__module__}.{name} = {_told(value)}")
            elif called not in seen:
                seen.add(called)
                waiting.append(called)
    return tuple(sorted(marks))


def _used(function: Function) -> Iterator[tuple[str, object]]:
    """Yield what a function finds in its module and around itself, by name."""
    code = function.__code__
    for name in sorted(set(_names(code))):
        if name in function.__globals__:
            yield name, function.__globals__[name]
    for name, cell in zip(code.co_freevars, function.__closure__ or (), strict=True):
        yield name, cell.cell_contents


def _names(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


def _told(value: object) -> str:
    """Return a value as text; of what is no number but a module or a class its name."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype}{value.tolist()}"
    if isinstance(value, ModuleType):
        return value.__name__
    return str(getattr(value, "__qualname__", None) or repr(value))
