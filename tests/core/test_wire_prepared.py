"""A prepared message has the bytes of the message that has the same values."""

from typing import Any

import pytest

from rosbase.messages import Header, Image, Imu, JointState, Odometry, TFMessage, Time
from rosbase.messages.widths import TYPECODES, Width
from rosbase.wire import maker, packer, serialize
from rosbase.wire.description import Field, Kind, MessageType, describe
from support.wire_messages import CLASSES, Rolled, flat, made, name_of

TIMES = ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")


def paths_of(of: MessageType, prefix: str = "") -> dict[str, Field]:
    """Every field that can vary, by its path."""
    found: dict[str, Field] = {}
    for one in of.fields:
        path = f"{prefix}{one.name}"
        if numbers_in(one) is not None:
            found[path] = one
        if isinstance(one.element, MessageType) and one.kind is Kind.ONE:
            found |= paths_of(one.element, f"{path}.")
    return found


def numbers_in(one: Field) -> list[Width] | None:
    """The widths of the numbers of a field; None if it cannot vary."""
    if one.kind is Kind.SEQUENCE:
        return None
    if not isinstance(one.element, MessageType):
        count = 1 if one.kind is Kind.ONE else one.size
        return [one.element] * count if one.element in TYPECODES else None
    parts = [numbers_in(inner) for inner in one.element.fields]
    if one.kind is not Kind.ONE or not parts or None in parts:
        return None
    return [width for part in parts for width in part or []]


def value_of(one: Field, choose: Rolled) -> Any:
    if isinstance(one.element, MessageType) and one.element.name in TIMES:
        return choose.dice.randrange(2**31 * 10**9)
    numbers = [choose.number(width) for width in numbers_in(one) or []]
    return numbers[0] if one.kind is Kind.ONE and one.element in TYPECODES else tuple(numbers)


@pytest.mark.parametrize("cls", CLASSES, ids=name_of)
def test_it_has_the_bytes_and_the_values_of_the_message_that_is_made(cls: type) -> None:
    choose, of = Rolled(31), describe(cls)
    paths = paths_of(of)
    for _ in range(10):
        template = made(of, choose)
        order = choose.dice.sample(sorted(paths), len(paths))
        varying: list[str] = []
        for path in order[: choose.dice.randint(0, 6)]:
            if not any(f"{path}.".startswith(f"{v}.") or v.startswith(f"{path}.") for v in varying):
                varying.append(path)
        make, pack = maker(template, varying), packer(template, varying)
        for _ in range(3):
            values = [value_of(paths[path], choose) for path in varying]
            message = make(*values)
            assert pack(*values) == serialize(message)
            rest = [(place, value) for place, value in flat(message) if not is_in(place, varying)]
            before = [
                (place, value) for place, value in flat(template) if not is_in(place, varying)
            ]
            assert rest == before


def is_in(place: str, paths: list[str]) -> bool:
    plain = place.removeprefix(".")
    return any(plain == path or plain.startswith((f"{path}.", f"{path}[")) for path in paths)


@pytest.mark.parametrize(
    ("template", "path"),
    [
        (Imu(), "header"),
        (Imu(), "header.frame_id"),
        (Imu(), "orientation.q"),
        (Imu(), ""),
        (Imu(), "nothing"),
        (JointState(), "position"),
        (Image(), "data"),
        (TFMessage(), "transforms"),
        (Odometry(), "pose.pose.orientation.x.y"),
        (Header(Time()), "stamp.sec.x"),
    ],
)
def test_a_field_without_a_fixed_number_of_numbers_cannot_vary(template: Any, path: str) -> None:
    for prepare in (maker, packer):
        with pytest.raises(ValueError, match=rf"^\w+\.{path} cannot vary: it has no fixed number"):
            prepare(template, [path])


@pytest.mark.parametrize(
    "paths",
    [
        ["orientation", "orientation"],
        ["orientation", "orientation.x"],
        ["header.stamp.sec", "header.stamp"],
    ],
)
def test_a_field_cannot_vary_twice(paths: list[str]) -> None:
    for prepare in (maker, packer):
        with pytest.raises(ValueError, match=r"^Imu\.\S+ cannot vary: it is named twice$"):
            prepare(Imu(), paths)
