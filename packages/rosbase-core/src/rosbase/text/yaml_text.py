"""Write plain data as YAML, letter for letter as PyYAML does. Pure.

So `rosbase topic echo` prints what `ros2 topic echo` prints, and needs no PyYAML. The rules for
texts are those of PyYAML's emitter (`analyze_scalar`, `choose_scalar_style`). One differs:
invisible characters, such as marks of the reading direction, are escaped, because a message is
text from outside.
"""

from __future__ import annotations

import re
from math import isfinite

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator
    from typing import Any

__all__ = ["as_yaml", "is_plain_text"]

_NOT_FIRST = "#,[]{}&*!|>'\"%@`"
# Unquoted, these would be read as something other than a text: YAML 1.1, as PyYAML resolves it.
_OTHER = re.compile(
    r"""(?:
    yes|Yes|YES|no|No|NO|true|True|TRUE|false|False|FALSE|on|On|ON|off|Off|OFF
    |~|null|Null|NULL|<<|=|
    |[-+]?(?:[0-9][0-9_]*)\.[0-9_]*(?:[eE][-+][0-9]+)?
    |\.[0-9][0-9_]*(?:[eE][-+][0-9]+)?
    |[-+]?[0-9][0-9_]*(?::[0-5]?[0-9])+\.[0-9_]*
    |[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)
    |[-+]?0b[0-1_]+|[-+]?0[0-7_]+|[-+]?(?:0|[1-9][0-9_]*)|[-+]?0x[0-9a-fA-F_]+
    |[-+]?[1-9][0-9_]*(?::[0-5]?[0-9])+
    |[0-9]{4}-[0-9]{2}-[0-9]{2}
    |[0-9]{4}-[0-9]{1,2}-[0-9]{1,2}(?:[Tt]|[\ \t]+)[0-9]{1,2}:[0-9]{2}:[0-9]{2}
        (?:\.[0-9]*)?(?:[\ \t]*(?:Z|[-+][0-9]{1,2}(?::[0-9]{2})?))?
    )""",
    re.VERBOSE,
)
_COLON = re.compile(r":(?:[ \n]|$)|[ \n]#")
_ESCAPES = {
    "\0": "0", "\a": "a", "\b": "b", "\t": "t", "\n": "n", "\v": "v", "\f": "f", "\r": "r",
    "\x1b": "e", '"': '"', "\\": "\\", "\x85": "N", "\u2028": "L", "\u2029": "P",
}  # fmt: skip


def as_yaml(
    data: dict[str, Any] | list[Any], *, flow: bool = False, sort_keys: bool = False
) -> str:
    """Return data as YAML, with a line end.

    Args:
        data: A dict or a list, of dicts, lists, tuples, texts, numbers, truth values and None.
        flow: Write all of it in one line, with brackets.
        sort_keys: Write the keys of a dict in order, instead of as they come.
    """
    writer = _Writer(sort_keys=sort_keys)
    if flow or not data:
        return f"{writer.flow(data)}\n"
    return "\n".join(writer.block(data, 0)) + "\n"


def is_plain_text(text: str) -> bool:
    """Return whether YAML reads the text as a text if it stands without quotes."""
    return not _OTHER.fullmatch(text)


class _Writer:
    """Writes values in the block style or the flow style."""

    def __init__(self, *, sort_keys: bool) -> None:
        self._sort_keys = sort_keys

    def flow(self, data: Any) -> str:
        if isinstance(data, dict):
            pairs = (f"{self._scalar(k, 0, 'flow')}: {self.flow(v)}" for k, v in self._items(data))
            return f"{{{', '.join(pairs)}}}"
        if isinstance(data, (list, tuple)):
            return f"[{', '.join(self.flow(item) for item in data)}]"
        return self._scalar(data, 0, "flow")

    def block(self, data: Any, indent: int) -> Iterator[str]:
        """Yield the lines of a dict or a list that is not empty."""
        pad = " " * indent
        if isinstance(data, dict):
            for key, value in self._items(data):
                yield from self._pair(f"{pad}{self._scalar(key, indent, 'key')}:", value, indent)
            return
        for item in data:
            if isinstance(item, (dict, list, tuple)) and item:
                first, *others = self.block(item, indent + 2)
                yield f"{pad}- {first[indent + 2 :]}"
                yield from others
            else:
                yield f"{pad}- {self._leaf(item, indent)}"

    def _pair(self, head: str, value: Any, indent: int) -> Iterator[str]:
        if isinstance(value, dict) and value:
            yield head
            yield from self.block(value, indent + 2)
        elif isinstance(value, (list, tuple)) and value:
            yield head
            # PyYAML does not indent a list within a dict.
            yield from self.block(value, indent)
        else:
            yield f"{head} {self._leaf(value, indent)}"

    def _leaf(self, value: Any, indent: int) -> str:
        if isinstance(value, (dict, list, tuple)):
            return self.flow(value)
        return self._scalar(value, indent, "block")

    def _items(self, data: dict[Any, Any]) -> Any:
        return sorted(data.items()) if self._sort_keys else data.items()

    @staticmethod
    def _scalar(value: Any, indent: int, place: str) -> str:
        if value is None:
            return "null"
        if isinstance(value, bool):
            return "true" if value else "false"
        if isinstance(value, float):
            return _number(value)
        return _text(value, indent, place) if isinstance(value, str) else str(value)


def _number(value: float) -> str:
    if not isfinite(value):
        return {"inf": ".inf", "-inf": "-.inf"}.get(repr(value), ".nan")
    text = repr(value)
    # YAML 1.1 wants a point in it.
    return text.replace("e", ".0e", 1) if "." not in text and "e" in text else text


def _text(text: str, indent: int, place: str) -> str:
    """Return a text, with quotes if it needs them; `place` is key, flow or block."""
    has_breaks = "\n" in text
    odd = not all(c in "\n\xa0" or c.isprintable() for c in text)
    if not (odd or " \n" in text or "\n " in text or (has_breaks and place != "block")):
        if not (has_breaks or _needs_quotes(text, in_flow=place == "flow")):
            return text
        pad = " " * (indent + 2)
        quoted = text.replace("'", "''")
        # The first of several line ends is a blank, when a quoted text is read.
        return "'" + re.sub("\n+", lambda run: f"\n{run[0]}{pad}", quoted) + "'"
    return '"' + "".join(map(_escaped, text)) + '"'


def _needs_quotes(text: str, *, in_flow: bool) -> bool:
    if _OTHER.fullmatch(text) or text[0] == " " or text[-1] == " ":
        return True
    if text.startswith(("---", "...")) or text[0] in _NOT_FIRST:
        return True
    if text[0] in "-?:" and (text[1:2] in ("", " ", "\n") or (in_flow and text[0] != "-")):
        return True
    if _COLON.search(text):
        return True
    return in_flow and any(character in ",?[]{}:" for character in text[1:])


def _escaped(character: str) -> str:
    if character in _ESCAPES:
        return f"\\{_ESCAPES[character]}"
    if character == "\xa0" or (character.isprintable() and character <= "\ufffd"):
        return character
    number = ord(character)
    if number <= 0xFF:
        return f"\\x{number:02X}"
    return f"\\u{number:04X}" if number <= 0xFFFF else f"\\U{number:08X}"
