"""Streams that a program has refused, as a line for the user."""

from collections.abc import Collection, Sequence

from rosbase.control.questions.base import label
from rosbase.control.shapes import Process
from rosbase_view.attached.wanted import Tag

__all__ = ["Refusals"]

_SUBJECTS = {"counts": "rates", "log": "log"}


class Refusals:
    """Keeps the reasons as long as the streams are wanted. Any thread may call it."""

    def __init__(self) -> None:
        """Begin with none."""
        self._reasons: dict[Tag, str] = {}

    def add(self, tag: Tag, reason: str) -> None:
        """Take the reason why a stream was refused."""
        self._reasons[tag] = reason

    def forget(self, tag: Tag) -> None:
        """Take that a stream has come, after all."""
        self._reasons.pop(tag, None)

    def keep(self, wanted: Collection[Tag]) -> None:
        """Forget the streams that are not wanted any more."""
        for tag in self._reasons.copy().keys() - wanted:
            self.forget(tag)

    def line(self, processes: Sequence[Process]) -> str:
        """Return a line about all of them; empty if there are none."""
        names = {process["pid"]: label(process) for process in processes}
        lines = {
            f"no {_SUBJECTS.get(tag.kind, tag.kind)} of {names[tag.pid]}: {reason}"
            for tag, reason in self._reasons.copy().items()
            if tag.pid in names
        }
        return "; ".join(sorted(lines))
