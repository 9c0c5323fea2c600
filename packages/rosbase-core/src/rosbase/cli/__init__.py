"""The command `rosbase`: thin; what it does is done by the floors below."""

import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Runs a command line; gives the exit status.

    What a user can mend is one line on stderr and status 2, never a traceback.
    """
    with _quiet_ctrl_c():
        # Only now, when Ctrl-C during the imports does no harm any more.
        from rosbase.cli.run import run

        return run(list(sys.argv[1:] if argv is None else argv))


@contextmanager
def _quiet_ctrl_c() -> Iterator[None]:
    """Lets Ctrl-C end the process without a traceback, until a run takes care of it itself."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
