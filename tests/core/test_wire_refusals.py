"""A value that a field cannot hold is an error of one line that names the field."""

import enum
from fractions import Fraction
from typing import Any

import attrs
import pytest

from rosbase.messages import Header, Image, Imu, JointState, Odometry, Time, UInt8
from rosbase.messages.widths import TYPECODES, Width
from rosbase.wire import serialize
from rosbase.wire.description import Field, Kind, MessageType, describe
from support.wire_messages import CLASSES, FLOAT32_MAX, Rolled, made, name_of

BAD_NUMBERS: list[Any] = [None, "1", b"12", 1j, True, [1], object(), Time()]
BAD_TEXTS: list[Any] = [None, 1, b"text", ["a"], Time()]
BAD_MESSAGES: list[Any] = [None, 1, "text", UInt8(), object()]
BAD_LISTS: list[Any] = [None, 1, "text", {}, {1.0}, object(), iter(())]


def bad_values(one: Field) -> list[Any]:
    """Values that a field or an element of that type cannot hold."""
    if isinstance(one.element, MessageType):
        # Without fields, nothing can be missing.
        return BAD_MESSAGES if one.element.fields else []
    if one.element in (Width.STRING, Width.WSTRING):
        return [*BAD_TEXTS, "a\0b", "\ud800", *(["x" * 9999] if one.text_limit else [])]
    if one.element is Width.BOOL:
        return [None, 1, 0, "True", 1.0]
    if one.element is Width.FLOAT64:
        return [*BAD_NUMBERS, 10**400]
    if one.element is Width.FLOAT32:
        return [*BAD_NUMBERS, 10**400, 3.5e38, -3.5e38]
    bits = int("".join(filter(str.isdigit, one.element.value)) or 8)
    ends = [1 << bits, -(1 << bits), *([-1] if "u" in one.element.value else [])]
    return [*BAD_NUMBERS, 1.0, *ends]


def bad_messages(message: Any, of: MessageType, where: str) -> Any:
    """Yield messages with one wrong value each, and the place of that value."""
    for one in of.fields:
        value, place = getattr(message, one.name), f"{where}.{one.name}"
        if one.kind is Kind.ONE:
            for bad, bad_place in [(bad, place) for bad in bad_values(one)] + (
                list(bad_messages(value, one.element, place))
                if isinstance(one.element, MessageType)
                else []
            ):
                yield changed(message, one, bad), bad_place
            continue
        for bad in BAD_LISTS:
            yield changed(message, one, bad), place
        if one.kind is Kind.ARRAY:
            yield changed(message, one, tuple(value)[:-1]), place
            yield changed(message, one, (*value, value[-1])), place
        elements = list(value)
        if elements:
            for bad in bad_values(one):
                yield changed(message, one, (bad, *elements[1:])), place


def changed(message: Any, one: Field, value: Any) -> Any:
    """The message with another value, whatever its constructor says of that."""
    other = object.__new__(type(message))
    for field in attrs.fields(type(message)):
        object.__setattr__(other, field.name, getattr(message, field.name))
    object.__setattr__(other, one.name, value)
    return other


@pytest.mark.parametrize("cls", CLASSES, ids=name_of)
def test_every_wrong_value_of_every_field_is_refused_by_the_name_of_its_field(cls: type) -> None:
    of, choose = describe(cls), Rolled(11)
    good = made(of, choose)
    serialize(good)
    for bad, place in bad_messages(good, of, cls.__name__):
        with pytest.raises((TypeError, ValueError)) as caught:
            serialize(bad)
        text = str(caught.value)
        assert text.startswith(f"{place} takes ")
        assert "\n" not in text
        assert type(caught.value) in (TypeError, ValueError)
        assert len(text) < 200


# Typed loosely, for what a type checker would see.
header: Any = Header
time: Any = Time
imu: Any = Imu
joints: Any = JointState


@pytest.mark.parametrize(
    ("message", "text"),
    [
        (Imu(Header(Time(2**31))), "Imu.header.stamp.sec takes whole numbers from -2147483648 to "),
        (
            Imu(Header(Time(0, -1))),
            "Imu.header.stamp.nanosec takes whole numbers from 0 to 4294967",
        ),
        (imu(header(time(0, 1.5))), "Imu.header.stamp.nanosec takes whole numbers, not float"),
        (imu(header(frame_id=None)), "Imu.header.frame_id takes text, not None"),
        (imu(header=None), "Imu.header takes messages of type Header, not None"),
        (
            Odometry(child_frame_id="\ud800"),
            "Odometry.child_frame_id takes text without NUL and without lone surrogates",
        ),
        (joints(name=("a", 2)), "JointState.name takes text, not int"),
        (joints(name="hip"), "JointState.name takes a tuple, not str"),
        (joints(position=(1.0, None)), "JointState.position takes numbers, not None"),
        (Image(data=(1, 256)), "Image.data takes whole numbers from 0 to 255"),
    ],
)
def test_errors_say_what_the_field_takes(message: Any, text: str) -> None:
    with pytest.raises((TypeError, ValueError)) as caught:
        serialize(message)
    assert str(caught.value).startswith(text)


def test_something_that_is_no_message_is_refused() -> None:
    for value in (None, 1, "text", object(), Imu, {"header": None}):
        with pytest.raises(TypeError, match=r"is no message: decorate it with @message\("):
            serialize(value)


class Mode(str, enum.Enum):
    MANUAL = "manual"


class Level(enum.IntEnum):
    HIGH = 7


def test_subclasses_of_texts_and_numbers_are_written_as_their_values() -> None:
    assert serialize(Header(frame_id=Mode.MANUAL)) == serialize(Header(frame_id="manual"))
    assert serialize(UInt8(Level.HIGH)) == serialize(UInt8(7))
    # Whatever else is unusual in the message.
    unusual = joints(Header(frame_id=Mode.MANUAL), (Mode.MANUAL,), (1, Fraction(1, 2)))
    usual = JointState(Header(frame_id="manual"), ("manual",), (1.0, 0.5))
    assert serialize(unusual) == serialize(usual)


def test_the_largest_float_of_32_bits_is_written_and_infinite_ones_too() -> None:
    from rosbase.messages import Float32

    for real in (FLOAT32_MAX, -FLOAT32_MAX, float("inf"), float("-inf")):
        serialize(Float32(real))
    for real in (FLOAT32_MAX * 1.001, -1e300):
        with pytest.raises(ValueError, match=r"^Float32\.data takes numbers that a 32-bit float"):
            serialize(Float32(real))


def test_every_number_has_a_typecode() -> None:
    assert set(Width) - set(TYPECODES) == {Width.STRING, Width.WSTRING}
