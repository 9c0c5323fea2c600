"""The command `rosbase`: a thin layer over the packages below."""

# As little as can be: until `main` has begun, Ctrl-C is Python's, which prints a traceback.
import signal
import sys

__all__ = ["main"]


def main(argv: list[str] | None = None) -> int:
    """Run a command line; return the exit status.

    A usage error is one line on stderr and status 2, never a traceback. Ctrl-C ends the
    process quietly, until a run handles it itself.
    """
    try:
        before = signal.signal(signal.SIGINT, signal.SIG_DFL)
    except ValueError:
        # Not the main thread, which alone has to do with signals.
        before = None
    try:
        from rosbase.cli.run import run

        return run(sys.argv[1:] if argv is None else argv)
    finally:
        if before is not None:
            signal.signal(signal.SIGINT, before)
