"""Messages as text, as `ros2 topic echo` prints them: YAML, CSV and JSON. Pure.

Long lists and texts follow the rules of rosidl_runtime_py (`message_to_yaml` and
`message_to_csv`).
"""

from __future__ import annotations

from math import isfinite, isnan

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

__all__ = ["Limits", "as_csv", "as_json", "harmless", "shortened", "writer_for"]

_CUT = "..."
# As `ros2 topic echo` has it.
_MOST_SHOWN = 128
_QUOTED = frozenset(',"\n')


class Limits:
    """Limits of lists and texts in a message."""

    __slots__ = ("length", "no_lists", "no_texts")

    def __init__(
        self, length: int | None = None, *, no_lists: bool = False, no_texts: bool = False
    ) -> None:
        self.length = length
        """Most elements of a list and characters of a text; None for all."""
        self.no_lists = no_lists
        self.no_texts = no_texts


def writer_for(given: Any) -> Callable[[Any], str]:
    """Return the function that writes a message, or a field of one, as the options say."""
    length = given.truncate_length
    if length is None and not given.json and not given.csv:
        # What other programs read is complete, unless the user wants it short.
        length = _MOST_SHOWN
    limits = Limits(
        None if given.full_length else length,
        no_lists=given.no_arr,
        no_texts=given.no_str,
    )
    if given.json:
        return lambda value: f"{as_json(value, limits)}\n"
    if given.csv:
        return lambda value: f"{as_csv(value, limits)}\n"
    # JSON and CSV need it not.
    from rosbase.text.yaml_text import as_yaml

    def write(value: Any) -> str:
        value = shortened(value, limits)
        if isinstance(value, dict):
            return f"{as_yaml(value, flow=given.flow_style)}---\n"
        return f"{harmless(value)}\n---\n"

    return write


def harmless(value: Any) -> str:
    """Return a value that is no message as text that is safe for a terminal."""
    text = str(value)
    if all(character in "\n\t" or character.isprintable() for character in text):
        return text
    return "".join(
        c if c in "\n\t" or c.isprintable() else c.encode("unicode_escape").decode() for c in text
    )


def shortened(value: Any, limits: Limits) -> Any:
    """Return a value as dicts, lists, texts and numbers, without what the limits leave out."""
    if isinstance(value, dict):
        return {name: shortened(one, limits) for name, one in value.items()}
    if isinstance(value, str):
        return _short_text(value, limits)
    if isinstance(value, (list, tuple, memoryview, bytes)):
        if limits.no_lists:
            return f"<sequence type: length: {len(value)}>"
        if limits.length is None or len(value) <= limits.length:
            return [shortened(one, limits) for one in value]
        return [*(shortened(one, limits) for one in value[: limits.length]), _CUT]
    return value


def _short_text(text: str, limits: Limits) -> str:
    if limits.no_texts:
        return f"<string length: <{len(text)}>>"
    if limits.length is None or len(text) <= limits.length:
        return text
    return text[: limits.length] + _CUT


def as_csv(value: Any, limits: Limits) -> str:
    """Return all values of a message, one after the other, with commas between them (RFC 4180).

    `ros2` leaves out the quotes, so that nobody can read back a text with a comma.
    """
    if isinstance(value, dict):
        return ",".join(as_csv(one, limits) for one in value.values())
    if isinstance(value, (list, tuple, memoryview, bytes)):
        if limits.no_lists:
            return str(shortened(value, limits))
        parts = [as_csv(one, limits) for one in value[: limits.length]]
        return ",".join([*parts, _CUT] if len(parts) < len(value) else parts)
    text = harmless(_short_text(value, limits) if isinstance(value, str) else value)
    if _QUOTED.isdisjoint(text):
        return text
    return '"' + text.replace('"', '""') + '"'


def as_json(value: Any, limits: Limits) -> str:
    """Return a message as one line of JSON.

    Numbers that JSON cannot carry are the texts NaN, Infinity and -Infinity, as in the JSON of
    Protocol Buffers. `float` of Python and `Number` of JavaScript read them.
    """
    # YAML needs it not.
    import json

    return json.dumps(_for_json(shortened(value, limits)), separators=(", ", ": "))


def _for_json(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _for_json(one) for name, one in value.items()}
    if isinstance(value, list):
        return [_for_json(one) for one in value]
    if isinstance(value, float) and not isfinite(value):
        return "NaN" if isnan(value) else "Infinity" if value > 0 else "-Infinity"
    return value
