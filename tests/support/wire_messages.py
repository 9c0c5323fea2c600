"""Messages of every class, made from its description: by hypothesis, or quickly at random."""

import pkgutil
import random
import struct
from array import array
from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any, Protocol

from hypothesis import strategies as st

from rosbase import messages
from rosbase.messages.fields import ros_type
from rosbase.messages.widths import TYPECODES, Width
from rosbase.wire.description import Field, Kind, MessageType, describe

__all__ = ["CLASSES", "FLOAT32_MAX", "Rolled", "flat", "made", "messages_of", "name_of"]

_MOST_ELEMENTS = 3
_FLOATS = (Width.FLOAT32, Width.FLOAT64)
FLOAT32_MAX = 3.4028234663852886e38
_RANGES = {
    Width.BYTE: (0, 255),
    Width.CHAR: (0, 255),
    **{Width(f"int{bits}"): (-(1 << bits - 1), (1 << bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{Width(f"uint{bits}"): (0, (1 << bits) - 1) for bits in (8, 16, 32, 64)},
}


def _classes() -> Iterator[type]:
    for found in pkgutil.iter_modules(messages.__path__):
        module = import_module(f"{messages.__name__}.{found.name}")
        for one in (getattr(module, name) for name in module.__all__):
            if ros_type(one) and one.__module__ == module.__name__:
                yield one


def name_of(cls: Any) -> str:
    """The ROS name of a message class: the name of its tests."""
    return str(ros_type(cls))


CLASSES = sorted(_classes(), key=name_of)
"""Every message class of rosbase."""


class Choices(Protocol):
    """What a random message is made of."""

    def number(self, width: Width) -> Any:
        """A number of that width, extreme ones included."""

    def text(self, limit: int) -> str:
        """A text without NUL, of at most that many bytes; 0: any."""

    def count(self, most: int) -> int:
        """A number of elements."""


def made(of: MessageType, choose: Choices) -> Any:
    """A message of random values."""
    return of.cls(**{one.alias: _field(one, choose) for one in of.fields})


def _field(one: Field, choose: Choices) -> Any:
    if one.kind is Kind.ONE:
        return _element(one, choose)
    if one.kind is Kind.ARRAY:
        count = one.size
    else:
        count = choose.count(min(one.size or _MOST_ELEMENTS, _MOST_ELEMENTS))
    values = tuple(_element(one, choose) for _ in range(count))
    return _as_buffer(one.element, values, choose) if one.is_buffer else values


def _as_buffer(width: Any, values: tuple[Any, ...], choose: Choices) -> Any:
    """The numbers as one of the things that a buffer may be."""
    code = TYPECODES[width]
    form = choose.count(2)
    if form == 0 or not values:
        return values
    numbers = bytes(values) if code == "?" else array(code, values).tobytes()
    if form == 1 and code == "B":
        return numbers
    loose: Any = memoryview(numbers)
    return loose.cast(code)


def _element(one: Field, choose: Choices) -> Any:
    if isinstance(one.element, MessageType):
        return made(one.element, choose)
    if one.element in (Width.STRING, Width.WSTRING):
        return choose.text(one.text_limit)
    return choose.number(one.element)


class _Drawn:
    """Choices of hypothesis."""

    def __init__(self, draw: Callable[[st.SearchStrategy[Any]], Any]) -> None:
        self._draw = draw

    def number(self, width: Width) -> Any:
        return self._draw(_numbers[width])

    def text(self, limit: int) -> str:
        return str(self._draw(_texts if not limit else _short_texts(limit)))

    def count(self, most: int) -> int:
        return int(self._draw(st.integers(0, most)))


_numbers: dict[Width, st.SearchStrategy[Any]] = {
    Width.BOOL: st.booleans(),
    Width.FLOAT64: st.floats(),
    # The setters of ROS refuse the largest of all.
    Width.FLOAT32: st.floats(width=32).filter(lambda real: abs(real) != FLOAT32_MAX),
    **{width: st.integers(*ends) for width, ends in _RANGES.items()},
}
_characters = st.characters(exclude_categories=["Cs"], exclude_characters="\0")
_texts = st.text(_characters, max_size=9)


def _short_texts(limit: int) -> st.SearchStrategy[str]:
    return st.text(_characters, max_size=limit).filter(lambda text: len(text.encode()) <= limit)


def messages_of(cls: type) -> st.SearchStrategy[Any]:
    """Messages of a class, with everything that their fields can hold."""
    of = describe(cls)

    @st.composite
    def drawn(draw: Any) -> Any:
        return made(of, _Drawn(draw))

    return drawn()


class Rolled:
    """Choices of a random generator: a hundred times as quick, and without shrinking."""

    _SPECIAL = (0.0, -0.0, 1.5, float("inf"), float("-inf"), float("nan"), 1e-40, 3.4e38)
    _LETTERS = "ab/_ \n\x7fäßж€雪🧭\U0010ffff"

    def __init__(self, seed: int) -> None:
        self.dice = random.Random(seed)

    def number(self, width: Width) -> Any:
        """A number of that width, often an extreme one."""
        dice = self.dice
        if width is Width.BOOL:
            return dice.random() < 0.5
        if width in _FLOATS:
            real = dice.choice(self._SPECIAL) if dice.random() < 0.2 else dice.gauss(0.0, 1e3)
            return real if width is Width.FLOAT64 else struct.unpack("f", struct.pack("f", real))[0]
        low, high = _RANGES[width]
        return dice.choice((low, high)) if dice.random() < 0.2 else dice.randint(low, high)

    def text(self, limit: int) -> str:
        """A text of up to nine letters."""
        text = "".join(self.dice.choices(self._LETTERS, k=self.dice.randint(0, 9)))
        return text.encode()[:limit].decode(errors="ignore") if limit else text

    def count(self, most: int) -> int:
        """A number of elements."""
        return self.dice.randint(0, most)


def flat(message: Any, of: MessageType | None = None, where: str = "") -> list[tuple[str, object]]:
    """Every value of a message with its place, so that they can be compared.

    Buffers are the same as tuples, and NaN is the same as NaN. Messages of ROS are taken too.
    """
    of = of or describe(type(message))
    found: list[tuple[str, object]] = []
    for one in of.fields:
        value, place = getattr(message, one.name), f"{where}.{one.name}"
        if one.kind is Kind.ONE:
            found += _flat_element(value, one, place)
            continue
        values = value.tolist() if hasattr(value, "tolist") else list(value)
        found.append((f"{place}.len", len(values)))
        for index, element in enumerate(values):
            found += _flat_element(element, one, f"{place}[{index}]")
    return found


def _flat_element(value: Any, one: Field, place: str) -> list[tuple[str, object]]:
    if isinstance(one.element, MessageType):
        return flat(value, one.element, place)
    if isinstance(value, bytes):
        # As ROS has an octet.
        value = value[0]
    if one.element is Width.BYTE:
        # rosbags has it as a signed number.
        value &= 0xFF
    return [(place, repr(float(value)) if one.element in _FLOATS else value)]
