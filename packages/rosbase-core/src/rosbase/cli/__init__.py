"""The command `rosbase`: a thin layer over the packages below."""

# As little as can be: until `main` has begun, Ctrl-C is Python's, which prints a traceback.
import sys

__all__ = ["main"]

# First words of the commands for running programs, as in `operate.words`. They are over in some
# milliseconds, so they need neither plugins nor argparse.
_QUICK = frozenset(
    (
        *("_complete", "completion", "lifecycle", "log", "node", "param", "ps", "restart"),
        *("service", "stats", "stop", "topic"),
    )
)


def main(argv: list[str] | None = None) -> int:
    """Run a command line; return the exit status.

    A usage error is one line on stderr and status 2, never a traceback. Ctrl-C ends the
    process quietly, until a run handles it itself.
    """
    arguments = sys.argv[1:] if argv is None else argv
    if arguments and arguments[0] in _QUICK:
        return _run_quickly(arguments)
    # It takes a tenth of the time of a quick command.
    import signal

    try:
        before = signal.signal(signal.SIGINT, signal.SIG_DFL)
    except ValueError:
        # Not the main thread, which alone has to do with signals.
        before = None
    try:
        from rosbase.cli.run import run

        return run(arguments)
    finally:
        if before is not None:
            signal.signal(signal.SIGINT, before)


def _run_quickly(arguments: list[str]) -> int:
    try:
        from rosbase.cli.operate import run

        return run(arguments)
    except KeyboardInterrupt:
        # During the imports.
        return 130
