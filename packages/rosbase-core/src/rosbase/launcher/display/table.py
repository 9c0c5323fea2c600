"""The states of all programs as a table that fits the terminal."""

from collections import Counter
from collections.abc import Callable, Sequence

from rosbase.cli.panel.style import Style
from rosbase.launcher.display.cells import cut
from rosbase.launcher.display.lines import Labels
from rosbase.launcher.fleet import Entry, State
from rosbase.text.printable import printable

__all__ = ["draw_table", "duration"]

_NS_PER_S = 1_000_000_000
_LEAST_WIDTH, _LEAST_HEIGHT = 40, 12
_STATE_WIDTH = 10
_COLOURS: dict[State, str] = {
    "disabled": "dim",
    "waiting": "yellow",
    "running": "green",
    "restarting": "yellow",
    "stopping": "yellow",
    "stopped": "dim",
    "ended": "dim",
    "failed": "red",
}
# The ones that a user looks for come first if there is no room for all.
_BY_INTEREST: tuple[State, ...] = (
    *("failed", "restarting", "waiting", "stopping", "stopped", "running", "ended", "disabled"),
)


def draw_table(
    entries: Sequence[Entry],
    pid_of: Callable[[str], int | None],
    now_ns: int,
    size: tuple[int, int],
    labels: Labels,
    style: Style,
) -> list[str]:
    """Return the lines of the table, none of them wider than the terminal.

    Args:
        entries: The programs, in the order in which they are shown.
        pid_of: Returns the process id of a program that runs.
        now_ns: Present time, on the monotonic clock.
        size: Columns and lines of the terminal.
        labels: Names of the programs.
        style: Colours.
    """
    columns, lines = size
    if columns < _LEAST_WIDTH or lines < _LEAST_HEIGHT:
        return [_summary(entries, columns, style)]
    room = max(3, lines // 3 - 1)
    shown = list(entries)
    if len(shown) > room:
        urgent = sorted(entries, key=lambda entry: _BY_INTEREST.index(entry.state))[:room]
        shown = [entry for entry in entries if entry in urgent]
    rows = [_row(entry, pid_of(entry.key), now_ns, columns, labels, style) for entry in shown]
    return [*rows, _summary(entries, columns, style)]


def duration(nanoseconds: int) -> str:
    """Return a duration as `12 s`, `3:05` or `1:00:09`."""
    seconds = max(0, nanoseconds) // _NS_PER_S
    if seconds < 60:
        return f"{seconds} s"
    minutes, seconds = divmod(seconds, 60)
    if minutes < 60:
        return f"{minutes}:{seconds:02}"
    return f"{minutes // 60}:{minutes % 60:02}:{seconds:02}"


def _row(
    entry: Entry, pid: int | None, now_ns: int, columns: int, labels: Labels, style: Style
) -> str:
    left = [f"{entry.state:<{_STATE_WIDTH}}", f"{pid or '':>8}"]
    since = "" if entry.state == "disabled" else duration(now_ns - entry.since_ns)
    left.append(f"{since:>8}")
    times = "1 restart" if entry.total_restarts == 1 else f"{entry.total_restarts} restarts"
    rest = [entry.detail] if entry.detail else []
    rest += [times] if entry.total_restarts else []
    begin = labels.width + 1
    text = "  ".join([*left, ", ".join(rest)]).rstrip()
    text = cut(printable(text, columns), max(1, columns - begin))
    painted = style.paint(text[:_STATE_WIDTH], _COLOURS[entry.state])
    return f"{labels.name(entry.key)} {painted}{text[_STATE_WIDTH:]}"


def _summary(entries: Sequence[Entry], columns: int, style: Style) -> str:
    counts = Counter(entry.state for entry in entries)
    parts = [f"{counts[state]} {state}" for state in _BY_INTEREST if counts[state]]
    hint = ""
    if counts["running"] + counts["waiting"] + counts["restarting"]:
        hint = "; Ctrl-C stops all"
    elif counts["stopping"]:
        hint = "; Ctrl-C again ends them at once"
    text = f"{len(entries)} programs: {', '.join(parts)}{hint}"
    return style.paint(cut(text, columns), "dim")
