"""Messages of the local backend that can be changed after they were published."""

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any, NamedTuple

import attrs
import pytest

from rosbase import DurabilityPolicy, QoSProfile
from rosbase.messages import Vector3
from rosbase.testing import virtual_backend


@dataclass
class Row:
    numbers: list[int] = field(default_factory=list)


@attrs.define
class Cell:
    number: int = 0


@attrs.define
class Hooked:
    number: float = attrs.field(default=0.0, converter=float)


@attrs.define
class Validated:
    number: int = attrs.field(default=0, validator=attrs.validators.ge(0))


@attrs.define(on_setattr=attrs.setters.NO_OP)
class OwnSetter:
    number: int = 0

    def __setattr__(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)


@attrs.frozen
class Checked:
    number: float = attrs.field(default=0.0, converter=float, validator=attrs.validators.ge(0))


class Opened(Checked):
    """As a subclass has attributes of its own, it can be changed."""

    def __setattr__(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)


@dataclass(frozen=True)
class FrozenRow:
    numbers: tuple[int, ...] = ()


class OpenedRow(FrozenRow):
    """A subclass without the decorator."""

    def __setattr__(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)


class Pair(NamedTuple):
    left: int
    right: int


@pytest.mark.parametrize(
    "profile", [10, QoSProfile(10, durability=DurabilityPolicy.TRANSIENT_LOCAL)], ids=str
)
def test_one_object_that_is_filled_and_published_again_arrives_as_it_was_each_time(
    profile: Any,
) -> None:
    backend = virtual_backend()
    rows: list[Row] = []
    backend.create_subscription(Row, "rows", rows.append, profile)
    publisher = backend.create_publisher(Row, "rows", profile)
    row = Row()
    for number in range(8):
        row.numbers.append(number)
        publisher.publish(row)
    while backend.spin_once(0.0):
        pass
    assert [got.numbers for got in rows] == [list(range(number + 1)) for number in range(8)]
    backend.close()


@pytest.mark.parametrize(
    ("message", "is_copied"),
    [
        (Row([1]), True),
        (Cell(1), True),
        (SimpleNamespace(x=1), True),
        (Hooked(1), True),
        (Validated(1), True),
        (OwnSetter(1), True),
        (Opened(1), True),
        (OpenedRow((1,)), True),
        (FrozenRow((1,)), False),
        (Checked(1), False),
        (Pair(1, 2), False),
        (Vector3(1.0), False),
        ("text", False),
    ],
    ids=lambda value: type(value).__name__,
)
def test_what_can_be_changed_is_copied_and_nothing_else(message: Any, is_copied: bool) -> None:
    backend = virtual_backend()
    got: list[Any] = []
    backend.create_subscription(type(message), "topic", got.append, 10)
    backend.create_publisher(type(message), "topic", 10).publish(message)
    backend.spin_once(0.0)
    assert got == [message]
    assert (got[0] is not message) is is_copied
    backend.close()
