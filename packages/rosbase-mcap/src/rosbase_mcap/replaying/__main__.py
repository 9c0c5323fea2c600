"""The process of `rosbase replay`: `python -m rosbase_mcap.replaying OPTIONS PROGRAM ...`."""

import gc
import runpy
import sys
import traceback

from rosbase import RosbaseError
from rosbase.logger.console import use_console
from rosbase.text.printable import MOST_LINE, one_line
from rosbase_mcap.errors import McapError
from rosbase_mcap.replaying.late_console import LateConsole
from rosbase_mcap.replaying.options import ReplayOptions
from rosbase_mcap.replaying.report import report_lines, status_of
from rosbase_mcap.replaying.session import Session
from rosbase_mcap.surroundings import differences

__all__ = ["main"]

# As a shell has it: 128 and the number of SIGINT.
_INTERRUPTED = 130
# The garbage collector counts every entry, and none is part of a cycle. With Python's default, it
# takes some 4 % of the time.
_GARBAGE = 50_000


def main() -> int:
    """Replay a program as the command line says; return the exit status."""
    gc.set_threshold(_GARBAGE, *gc.get_threshold()[1:])
    options = ReplayOptions.from_text(sys.argv[1])
    words = sys.argv[2:]
    try:
        session = Session(options)
        found = [] if session.facts is None else differences(session.facts, words[0])
        if found:
            _say(f"this may be why the replay differs, if it does: {'; '.join(found)}")
        status = _run(session, words)
    except RosbaseError as error:
        _say(one_line(str(error), MOST_LINE))
        return 2
    if not session.has_begun:
        _say(f"{words[0]} has no manager and no standalone node: nothing was replayed")
        return status or 2
    outcome = session.outcome
    for line in report_lines(outcome, options):
        print(line, file=sys.stderr)
    return status or status_of(outcome, options)


def _run(session: Session, words: list[str]) -> int:
    """Run the program as `rosbase run` does; return its exit status."""
    sys.argv = ["rosbase", *words]
    use_console(LateConsole(lambda: session.is_early))
    with session.conducting():
        try:
            runpy.run_module("rosbase.program", run_name="__main__", alter_sys=True)
        except SystemExit as end:
            return _status(end)
        except McapError:
            raise
        except BaseException as error:
            # Of the program, which may have ended so in the recording, too.
            if not session.has_begun:
                raise
            traceback.print_exc()
            return _INTERRUPTED if isinstance(error, KeyboardInterrupt) else 1
    return 0


def _status(end: SystemExit) -> int:
    if end.code is None or isinstance(end.code, int):
        return end.code or 0
    print(end.code, file=sys.stderr)
    return 1


def _say(line: str) -> None:
    print(f"rosbase replay: {line}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
