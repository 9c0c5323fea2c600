"""Pickle messages with buffers: pickle refuses a memoryview, and makes numpy arrays writable."""

from collections.abc import Callable
from typing import Any

__all__ = ["make_picklable"]

_USUAL = frozenset({bool, bytes, float, int, str, tuple})


def make_picklable(cls: Any) -> None:
    """Have instances of a frozen class pickled whatever their buffers are.

    Nothing is copied until an instance is pickled. Bytes and tuples stay as they are.
    """
    own: Callable[[Any], Any] = vars(cls).get("__getstate__", vars)

    def state_of(self: Any) -> Any:
        state = own(self)
        if isinstance(state, dict):
            return {name: _picklable(value) for name, value in state.items()}
        return [_picklable(value) for value in state] if isinstance(state, list) else state

    def itself(self: Any) -> Any:
        return self

    cls.__getstate__ = state_of
    # `copy.copy` would take the state as it is.
    cls.__copy__ = itself


def _picklable(value: Any) -> Any:
    if type(value) in _USUAL:
        return value
    if isinstance(value, memoryview):
        return _Pickled(_view, (value, value.format.lstrip("<=@"), value.shape))
    return _Pickled(_read_only, (value,)) if hasattr(value, "setflags") else value


class _Pickled:
    """Stands for a buffer in the state of a message, and is pickled as the buffer."""

    def __init__(self, restore: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
        self._restore = restore
        self._arguments = arguments

    def __reduce_ex__(self, protocol: Any) -> Any:
        # Whoever pickles has imported it, and most programs never do.
        from pickle import PickleBuffer  # noqa: PLC0415 - as said

        first, *rest = self._arguments
        if isinstance(first, memoryview):
            first = PickleBuffer(first) if protocol >= 5 else first.tobytes()
        return self._restore, (first, *rest)


def _view(data: Any, form: Any, shape: Any) -> memoryview:
    view = memoryview(data).toreadonly()
    # A view without elements cannot be cast to a shape.
    return view.cast(form, shape) if view.nbytes else view.cast(form)


def _read_only(numbers: Any) -> Any:
    """Return an array of numpy that pickle has just made, read-only as the one it was made of."""
    numbers.setflags(write=False)
    return numbers
