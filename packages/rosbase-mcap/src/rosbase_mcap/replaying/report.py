"""The result of a replay as lines for people. Pure."""

from rosbase_mcap.replaying.difference import clock_text
from rosbase_mcap.replaying.options import ReplayOptions
from rosbase_mcap.replaying.outcome import Outcome

__all__ = ["report_lines", "status_of"]


def report_lines(outcome: Outcome, options: ReplayOptions) -> list[str]:
    """Return the lines that end a replay."""
    lines = []
    difference = outcome.difference
    if difference is not None and (options.checks or difference.flow):
        lines += str(difference).splitlines()
    elif options.checks:
        count = f"{outcome.messages} messages and lines of the log"
        lines.append(f"no difference: {count} in {clock_text(outcome.duration_ns)}")
    if outcome.cut_short:
        lines.append(f"replayed up to {clock_text(outcome.duration_ns)}: {outcome.cut_short}")
    if options.checks:
        lines.append(f"sha256: {outcome.sha256}")
    return lines


def status_of(outcome: Outcome, options: ReplayOptions) -> int:
    """Return the exit status of a replay whose program has ended in order."""
    differs = options.checks and outcome.difference is not None
    return 1 if differs or outcome.cut_short else 0
