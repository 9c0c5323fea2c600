"""From a schema of the format `ros2msg` to the type that it describes, without its class.

Sources: docs.ros.org, "About ROS 2 interfaces" (fields, constants, defaults), and the registry of
MCAP (the messages within follow, each below a rule). Nobody is trusted: a schema that is wrong, or
whose messages would be too large, is a WireError.
"""

import re
import struct
from keyword import iskeyword
from typing import Any

from rosbase.errors import WireError
from rosbase.messages.widths import TYPECODES, Width
from rosbase.wire.cdr import SIZES
from rosbase.wire.structure import Constant, Field, Kind, MessageType

__all__ = ["full_name", "parse_schema"]

_LONGEST_TEXT = 1 << 20
_MOST_LEAVES = 20_000
_MOST_BYTES = 1 << 26
_MOST_DEPTH = 64
# A longer array of numbers becomes a buffer.
_LONGEST_TUPLE = 64
_RULE = re.compile(r"^={10,}[ \t]*\r?\nMSG:[ \t]*(\S*)[ \t]*\r?$", re.MULTILINE)
_NAME = re.compile(r"[A-Za-z]\w*(/[A-Za-z]\w*){0,2}", re.ASCII)
_LINE = re.compile(
    r"(?P<base>[A-Za-z][\w/]*)(<=(?P<limit>\d{1,9}))?(?P<many>\[(?P<most><=)?(?P<size>\d{0,9})\])?"
    r"[ \t]+(?P<name>_?[A-Za-z]\w*)[ \t]*(?P<rest>.*)",
    re.ASCII,
)
_WIDTHS = {width.value: width for width in Width}
_BOOLS = {"true": True, "1": True, "false": False, "0": False}


def parse_schema(type_name: str, text: str) -> MessageType:
    """Return the type of that name; numbers of any number, and of many, are buffers.

    Raises:
        WireError: The schema is wrong; the text names the line.
    """
    if len(text) > _LONGEST_TEXT:
        raise WireError(f"a schema has at most {_LONGEST_TEXT} characters, not {len(text)}")
    name = full_name(type_name)
    first, *others = _RULE.split(text)
    sections = {name: first}
    for title, body in zip(others[::2], others[1::2], strict=True):
        sections.setdefault(full_name(title), body)
    return _Parser(sections).type_of(name, 1)


def full_name(name: str) -> str:
    """Return the full name of a type: `std_msgs/String` is `std_msgs/msg/String`.

    Raises:
        WireError: It is no name of a type.
    """
    if not isinstance(name, str) or not _NAME.fullmatch(name) or "/" not in name:
        raise WireError(f"a type is named like sensor_msgs/msg/Imu, not {str(name)[:80]!r}")
    return name if name.count("/") == 2 else name.replace("/", "/msg/")


class _Parser:
    """The types of one schema, each made when it is first needed."""

    def __init__(self, sections: dict[str, str]) -> None:
        self._sections = sections
        self._made: dict[str, MessageType] = {}
        # Number of values and least number of bytes of each, those within included.
        self._weights: dict[str, tuple[int, int]] = {}

    def type_of(self, name: str, depth: int) -> MessageType:
        """Return a type."""
        found = self._made.get(name)
        if found is not None:
            return found
        body = self._sections.get(name)
        if body is None:
            raise WireError(f"the schema uses {name}, and does not define it")
        if depth > _MOST_DEPTH:
            raise WireError(f"the schema has messages within messages without an end, as {name}")
        fields: dict[str, Field] = {}
        constants = []
        leaves, size = 1, 1
        for line in body.splitlines():
            one = self._read(line, name, depth)
            if isinstance(one, Constant):
                constants.append(one)
            elif one is not None:
                if one.alias in fields:
                    raise WireError(f"{name} has two fields of the name {one.alias}")
                fields[one.alias] = one
                own_leaves, own_size = self._weigh(one)
                leaves, size = leaves + own_leaves, size + own_size
                if leaves > _MOST_LEAVES or size > _MOST_BYTES:
                    raise WireError(f"{name} is larger than any message may be")
        made = self._made[name] = MessageType(name, dict, tuple(fields.values()), constants)
        self._weights[name] = leaves, size
        return made

    def _weigh(self, one: Field) -> tuple[int, int]:
        if one.kind is Kind.SEQUENCE:
            return 1, 4
        count = one.size if one.kind is Kind.ARRAY else 1
        if isinstance(one.element, MessageType):
            leaves, size = self._weights[one.element.name]
        else:
            leaves, size = 1, SIZES.get(one.element, 4)
        return leaves, count * size

    def _read(self, line: str, within: str, depth: int) -> Field | Constant | None:
        text = line.strip()
        if not text or text.startswith("#"):
            return None
        found = _LINE.fullmatch(text)
        if found is None:
            raise WireError(f"{within}: this is no line of a schema: {text[:80]!r}")
        if found["rest"].startswith("="):
            return _constant(found, within)
        return self._field(found, within, depth)

    def _field(self, found: "re.Match[str]", within: str, depth: int) -> Field:
        element = self._element(found["base"], within, depth)
        limit, size = int(found["limit"] or 0), int(found["size"] or 0)
        kind = Kind.ONE
        if found["many"]:
            kind = Kind.ARRAY if size and not found["most"] else Kind.SEQUENCE
        name = found["name"]
        is_text = element in (Width.STRING, Width.WSTRING)
        if (limit and not is_text) or (found["size"] and not size) or (found["most"] and not size):
            raise WireError(f"{within}.{name} has no type of ROS: {found[0][:80]!r}")
        is_number = isinstance(element, Width) and element in TYPECODES
        return Field(
            # For the compiled functions, which use it as the name of an attribute.
            f"{name}_" if iskeyword(name) else name,
            name,
            element,
            kind,
            size,
            limit,
            is_buffer=is_number and (kind is Kind.SEQUENCE or size > _LONGEST_TUPLE),
            default=_default(found["rest"], element, kind, f"{within}.{name}"),
        )

    def _element(self, base: str, within: str, depth: int) -> "Width | MessageType":
        if base in _WIDTHS:
            return _WIDTHS[base]
        if base == "Header":
            base = "std_msgs/Header"
        elif "/" not in base:
            base = f"{within.partition('/')[0]}/{base}"
        return self.type_of(full_name(base), depth + 1)


def _constant(found: "re.Match[str]", within: str) -> Constant:
    width, name = _WIDTHS.get(found["base"]), found["name"]
    if width is None or found["many"]:
        raise WireError(f"{within}.{name} is a constant, and has no type for that")
    text = found["rest"][1:].strip()
    value = _value(_without_comment(text), width, f"{within}.{name}")
    return Constant(name, width, value)


def _default(text: str, element: "Width | MessageType", kind: Kind, where: str) -> Any:
    text = _without_comment(text)
    if not text:
        return None
    if isinstance(element, MessageType):
        raise WireError(f"{where} is a message, and cannot have the default {text[:80]!r}")
    if kind is Kind.ONE:
        return _value(text, element, where)
    if not (text.startswith("[") and text.endswith("]")):
        raise WireError(f"{where} cannot have the default {text[:80]!r}")
    inner = text[1:-1].strip()
    items = _split(inner, ",") if inner else []
    return tuple(_value(item, element, where) for item in items)


def _value(text: str, width: Width, where: str) -> Any:
    """Return the value of a constant or a default."""
    if width in (Width.STRING, Width.WSTRING):
        is_quoted = len(text) > 1 and text[0] in "\"'" and text[-1] == text[0]
        return re.sub(r"\\(.)", r"\1", text[1:-1]) if is_quoted else text
    try:
        if width is Width.BOOL:
            return _BOOLS[text.lower()]
        value = float(text) if width in (Width.FLOAT32, Width.FLOAT64) else int(text, 0)
        struct.pack(f"<{TYPECODES[width]}", value)
    except (KeyError, OverflowError, ValueError, struct.error):
        raise WireError(f"{where} is {width.value}, and cannot be {text[:80]!r}") from None
    return value


def _without_comment(text: str) -> str:
    return _split(text, "#")[0]


def _split(text: str, delimiter: str) -> list[str]:
    """Return the parts of a text, without blanks around them; none ends within quotes."""
    parts, begin, quote, before, is_escaped = [], 0, "", "", False
    for index, char in enumerate(text):
        if quote:
            is_escaped, was_escaped = char == "\\" and not is_escaped, is_escaped
            if char == quote and not was_escaped:
                quote = ""
        elif char in "\"'" and before in ("", "[", ","):
            quote = char
        elif char == delimiter:
            parts.append(text[begin:index].strip())
            begin = index + 1
        if not char.isspace():
            before = char
    if quote:
        # There was none: it is an apostrophe.
        return [part.strip() for part in text.split(delimiter)]
    return [*parts, text[begin:].strip()]
