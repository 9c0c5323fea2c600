"""Check functions that rosbase calls back and classes that it builds; errors are one clear line."""

import inspect
from collections.abc import Callable
from functools import partial
from typing import Any

__all__ = ["check_answer", "check_callback", "check_methods", "describe_unrun"]


def check_callback(callback: object, what: str) -> None:
    """Refuse a callback that rosbase cannot call, or whose body would never run.

    Calling a coroutine or generator function only makes an object; rosbase runs no event loop.

    Raises:
        TypeError: It is not callable, or a coroutine or generator function.
    """
    if not callable(callback):
        raise TypeError(f"{what} takes a function, not {callback!r}")
    function: Any = callback
    while isinstance(function, partial):
        function = function.func
    if not (inspect.isroutine(function) or inspect.isclass(function)):
        function = type(function).__call__
    if inspect.iscoroutinefunction(function) or inspect.isasyncgenfunction(function):
        raise TypeError(
            f"{what}: {_name(callback)} is async, and rosbase awaits nothing; "
            "use a plain function, and asyncio in a thread of its own"
        )
    if inspect.isgeneratorfunction(function):
        raise TypeError(
            f"{what}: {_name(callback)} is a generator (it has a `yield`): "
            "calling it would run nothing"
        )


def check_methods(component: object, names: tuple[str, ...]) -> None:
    """Refuse a component with a method that rosbase calls and that would never run.

    Raises:
        TypeError: One is a coroutine or generator function.
    """
    for name in names:
        method = getattr(component, name, None)
        # A name that is not a function belongs to the program.
        if callable(method):
            check_callback(method, f"{type(component).__name__}.{name}")


def describe_unrun(answer: object, what: str) -> str:
    """Describe an answer that is work which nobody runs; empty for any other answer.

    Args:
        answer: The value that a callback has returned.
        what: The callback, for the text.
    """
    if inspect.iscoroutine(answer):
        if inspect.getcoroutinestate(answer) == inspect.CORO_CREATED:
            # Python need not say the same again.
            answer.close()
        return (
            f"{what} returned the coroutine {answer.__qualname__}, and rosbase awaits nothing; "
            "use a plain function, and asyncio in a thread of its own"
        )
    if inspect.isgenerator(answer) or inspect.isasyncgen(answer):
        return f"{what} returned the generator {answer.__qualname__}, of which nothing has run"
    return ""


def check_answer(answer: object, what: str) -> None:
    """Refuse an answer that is a coroutine or a generator, which would count as true.

    Raises:
        TypeError: It is one.
    """
    if text := describe_unrun(answer, what):
        raise TypeError(text)


def _name(callback: Callable[..., object]) -> str:
    return str(getattr(callback, "__qualname__", repr(callback)))
