"""Join the logs of several programs into one, each record once."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rosbase.control.shapes import LogRecord, Process
    from rosbase.control.watching import Watch

__all__ = ["Repeats", "joined"]

_MOST_OPEN = 10_000


def joined(watch: Watch, repeats: Repeats, last: int | None) -> Iterator[LogRecord]:
    """Yield the records that programs have kept, in the order of time, and then those that come.

    Args:
        watch: The log of each program.
        repeats: Knows the programs.
        last: How many of the kept records, from the end; None for all.
    """
    expected = {s.connection.pid: s.answer.get("count", 0) for s in watch.streams}
    is_kept = any(expected.values())
    kept: list[LogRecord] = []
    for record in watch.pid_events():
        if not is_kept:
            if not repeats.has(record):
                yield record
            continue
        kept.append(record)
        expected[record["pid"]] = expected.get(record["pid"], 0) - 1
        # One that has ended in between sends no more.
        if not any(expected.get(stream.connection.pid, 0) > 0 for stream in watch.streams):
            is_kept = False
            yield from _newest(kept, repeats, last)
    if is_kept:
        yield from _newest(kept, repeats, last)


def _newest(kept: list[LogRecord], repeats: Repeats, last: int | None) -> list[LogRecord]:
    kept.sort(key=lambda record: record["stamp_ns"])
    found = [record for record in kept if not repeats.has(record)]
    return found if last is None else found[max(0, len(found) - last) :]


class Repeats:
    """Knows the records that a manager repeats, with the name of the child that logged them."""

    def __init__(self, processes: Iterable[Process]) -> None:
        self._processes: dict[int, Process] = {}
        # Texts of children, each with how often it was seen and not yet repeated.
        self._open: dict[tuple[int, str], int] = {}
        self.add(processes)

    def add(self, processes: Iterable[Process]) -> None:
        """Know more programs."""
        self._processes.update({process["pid"]: process for process in processes})
        known = self._processes
        self._children = {
            pid: {child["name"]: child["pid"] for child in program["children"]}
            for pid, process in known.items()
            for program in process["programs"]
            if any(child["pid"] in known for child in program["children"])
        }
        self._parents = {
            child for children in self._children.values() for child in children.values()
        }

    def has(self, record: LogRecord) -> bool:
        """Return whether the record repeats one that was seen before."""
        if record["pid"] in self._parents:
            if len(self._open) >= _MOST_OPEN:
                self._open.clear()
            key = record["pid"], record["text"]
            self._open[key] = self._open.get(key, 0) + 1
        children = self._children.get(record["pid"])
        if not children:
            return False
        name, colon, text = record["text"].partition(": ")
        key = children.get(name, 0), text
        if not colon or self._open.get(key, 0) == 0:
            return False
        self._open[key] -= 1
        if self._open[key] == 0:
            del self._open[key]
        return True
