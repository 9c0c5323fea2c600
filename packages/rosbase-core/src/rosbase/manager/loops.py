"""Choose the loop of a manager."""

from collections.abc import Callable
from functools import partial

from rosbase.contracts.backend import Backend
from rosbase.manager.main_loop import run_main_loop
from rosbase.manager.precise_loop import run_precise_loop

__all__ = ["TIMINGS", "loop_of"]

TIMINGS = ("normal", "precise")
"""The timings that a program may ask for."""


def loop_of(backend: Backend, timing: str) -> Callable[..., None]:
    """Return the loop for a backend, with the signature of `run_main_loop`.

    Args:
        backend: The backend of the program, which may be recorded or replayed.
        timing: One of `TIMINGS`.
    """
    # A virtual clock stands still while somebody spins, and needs no spinning.
    is_precise = timing == "precise" and not backend.is_in_virtual_time
    conductor = backend.conductor
    if conductor is None:
        return run_precise_loop if is_precise else run_main_loop
    if conductor.is_replay:
        from rosbase.manager.replayed_loop import run_replayed_loop

        return run_replayed_loop
    from rosbase.manager.recorded_loop import run_recorded_loop

    return partial(run_recorded_loop, is_precise=is_precise)
