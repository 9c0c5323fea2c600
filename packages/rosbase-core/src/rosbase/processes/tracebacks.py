"""Find Python's tracebacks in a child's output, so that they stand out in the log."""

__all__ = ["Tracebacks"]

_HEADING = "Traceback (most recent call last):"
_GROUP_HEADING = f"  + Exception Group {_HEADING}"
# A syntax error in the main module has no heading.
_PLACE = '  File "'
_LEADS = ("Exception in thread ", "Exception ignored in", "Fatal Python error: ")
_BETWEEN = (
    "During handling of the above exception, another exception occurred:",
    "The above exception was the direct cause of the following exception:",
)


class Tracebacks:
    """Tells which lines belong to a traceback, one by one."""

    __slots__ = ("_inside", "_is_group", "_prefix")

    def __init__(self) -> None:
        self._inside = False
        self._is_group = False
        self._prefix = ""

    def is_part(self, line: str) -> bool:
        """Return whether the next line is part of a traceback, from heading to exception."""
        if line.endswith(_HEADING):
            self._is_group = line.endswith(_GROUP_HEADING)
            heading = _GROUP_HEADING if self._is_group else _HEADING
            # Such as the name of a process, from a program that runs others.
            self._prefix = line.removesuffix(heading)
            self._inside = True
            return True
        line = line.removeprefix(self._prefix)
        if line.startswith((_PLACE, *_LEADS)):
            self._inside = self._inside or line.startswith(_PLACE)
            return True
        if self._inside and not line.startswith(" "):
            # The exception itself; a group ends with the line before this one.
            self._inside = False
            return not self._is_group or line in _BETWEEN
        return self._inside or line in _BETWEEN
