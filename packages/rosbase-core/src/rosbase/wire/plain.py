"""Messages as plain data, known by their schema alone: for programs that have no class of them.

A message is a dict of its fields, in their order. A text is a str, and a message within is a dict.
A sequence or a long array of numbers is a memoryview of the bytes, or `()` or `b""` if it is empty.
Other arrays and sequences are tuples.
"""

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

from rosbase.messages.widths import Width
from rosbase.wire.reading import Values, compiled_reader
from rosbase.wire.schema_text import parse_schema
from rosbase.wire.source import Source
from rosbase.wire.structure import Field, Kind, MessageType
from rosbase.wire.writing import compiled_writer

__all__ = ["decoder", "encoder"]

_FLOATS = (Width.FLOAT32, Width.FLOAT64)
_TEXTS = (Width.STRING, Width.WSTRING)
_BOOLS = {"true": True, "false": False, 1: True, 0: False}
_TIME, _HEADER = "builtin_interfaces/msg/Time", "std_msgs/msg/Header"
_NS_PER_S = 1_000_000_000


def decoder(type_name: str, schema: str) -> Callable[[bytes], dict[str, Any]]:
    """Return the function that reads messages of a type.

    It raises WireError for bytes that are no such message.

    Args:
        type_name: Name of the type, such as `sensor_msgs/msg/Imu`.
        schema: Its schema, of the format `ros2msg`.

    Raises:
        WireError: The schema is wrong.
    """
    return compiled_reader(parse_schema(type_name, schema), _make)


def encoder(
    type_name: str, schema: str, now_ns: Callable[[], int] | None = None
) -> Callable[[Mapping[str, Any] | None], bytes]:
    """Return the function that writes a message of a type, given as YAML or JSON has it.

    A field that is not given has its default. Numbers may be texts, and texts may be numbers, as
    `ros2 topic pub` takes them. The function raises TypeError for a value of the wrong kind, and
    ValueError for an unknown field and for a value out of the range of its field; the text names
    the field.

    Args:
        type_name: Name of the type, such as `sensor_msgs/msg/Imu`.
        schema: Its schema, of the format `ros2msg`.
        now_ns: Returns the date, in nanoseconds since 1970: what a time of `now` and a header of
            `auto` become. Without it, they are refused.

    Raises:
        WireError: The schema is wrong.
    """
    own = parse_schema(type_name, schema)
    name = own.name.rpartition("/")[2]
    write, fill = compiled_writer(own, name), _Filling(now_ns)

    def encode(values: Mapping[str, Any] | None) -> bytes:
        return write(fill.message(own, values, name))

    return encode


def _make(_source: Source, _building: list[str], _of: MessageType, values: Values) -> str:
    """Return the expression of a message: a dict."""
    return "{" + ", ".join(f"{one.alias!r}: {value}" for one, value in values) + "}"


class _Filling:
    """Makes objects with all fields of a type, which the writer takes."""

    def __init__(self, now_ns: Callable[[], int] | None) -> None:
        self._now_ns = now_ns
        self._empty: dict[str, SimpleNamespace] = {}

    def message(self, of: MessageType, values: Any, where: str) -> SimpleNamespace:
        """Return the message with these values, and its defaults."""
        if values is None:
            return self._default(of)
        if self._now_ns is not None and isinstance(values, str):
            values = self._at_this_time(of, values)
        if not isinstance(values, Mapping):
            raise TypeError(f"{where} takes fields with their values, not {values!r:.80}")
        if not values:
            return self._default(of)
        filled = dict(vars(self._default(of)))
        known = {one.alias: one for one in of.fields}
        for name, value in values.items():
            one = known.get(name)
            if one is None:
                raise _unknown(name, known, where)
            if value is not None:
                filled[one.name] = self._value(one, value, f"{where}.{name}")
        return SimpleNamespace(**filled)

    def _at_this_time(self, of: MessageType, word: str) -> Any:
        """Return what `ros2 topic pub` makes of these words; others as they are."""
        assert self._now_ns is not None
        if of.name == _TIME and word == "now":
            sec, nanosec = divmod(self._now_ns(), _NS_PER_S)
            return {"sec": sec, "nanosec": nanosec}
        return {"stamp": "now"} if of.name == _HEADER and word == "auto" else word

    def _default(self, of: MessageType) -> SimpleNamespace:
        found = self._empty.get(of.name)
        if found is None:
            values = {one.name: self._default_value(one) for one in of.fields}
            found = self._empty[of.name] = SimpleNamespace(**values)
        return found

    def _default_value(self, one: Field) -> Any:
        if one.default is not None:
            return one.default
        if one.kind is Kind.SEQUENCE:
            return ()
        if isinstance(one.element, MessageType):
            zero: Any = self._default(one.element)
        elif one.element in _TEXTS:
            zero = ""
        elif one.element is Width.BOOL:
            zero = False
        else:
            zero = 0.0 if one.element in _FLOATS else 0
        return zero if one.kind is Kind.ONE else (zero,) * one.size

    def _value(self, one: Field, value: Any, where: str) -> Any:
        if one.kind is Kind.ONE:
            return self._element(one, value, where)
        if isinstance(value, (list, tuple)):
            return tuple(
                self._element(one, element, f"{where}[{number}]")
                for number, element in enumerate(value)
            )
        if isinstance(one.element, MessageType) or isinstance(value, (str, Mapping)):
            raise TypeError(f"{where} takes a list, not {value!r:.80}")
        return value

    def _element(self, one: Field, value: Any, where: str) -> Any:
        if isinstance(one.element, MessageType):
            return self.message(one.element, value, where)
        if one.element in _TEXTS:
            return str(value) if isinstance(value, (bool, int, float)) else value
        try:
            return _number(one.element, value)
        except ValueError:
            raise ValueError(f"{where} takes {one.element.value}, not {value!r:.80}") from None


def _number(width: Width, value: Any) -> Any:
    """Return a number that is written in another way; anything else as it is."""
    if width is Width.BOOL:
        found = value.lower() if isinstance(value, str) else value
        return _BOOLS.get(found, value) if isinstance(found, (int, str)) else value
    if width in _FLOATS:
        return float(value) if isinstance(value, str) else value
    if isinstance(value, str):
        return int(value, 0)
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _unknown(name: Any, known: Mapping[str, Field], where: str) -> ValueError:
    # Imported for a mistake only.
    from difflib import get_close_matches

    close = get_close_matches(str(name), known, 1)
    hint = f"; did you mean {close[0]}?" if close else f": it has {', '.join(known) or 'none'}"
    return ValueError(f"{where} has no field {str(name)[:80]}{hint}")
