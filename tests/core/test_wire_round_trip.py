"""Every message becomes bytes and itself again, whatever its fields hold."""

from itertools import product
from typing import Any

import attrs
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosbase.messages.fields import Width
from rosbase.wire import deserialize, serialize
from rosbase.wire.cdr import SIZES
from rosbase.wire.description import Kind, MessageType, describe
from support.plain_cdr import PlainCdr
from support.wire_messages import CLASSES, Rolled, flat, made, messages_of, name_of

quick = settings(max_examples=20, suppress_health_check=list(HealthCheck))


def test_there_is_a_class_for_every_message_that_robots_send() -> None:
    names = {name_of(cls) for cls in CLASSES}
    assert len(names) == len(CLASSES) > 130
    assert {"sensor_msgs/msg/Imu", "tf2_msgs/msg/TFMessage", "std_srvs/srv/SetBool_Request"} < names


@pytest.mark.parametrize("cls", CLASSES, ids=name_of)
def test_the_default_message_and_random_ones_come_back_as_they_were(cls: type) -> None:
    choose = Rolled(1)
    for message in (cls(), *(made(describe(cls), choose) for _ in range(100))):
        data = serialize(message)
        assert data[:4] == b"\0\1\0\0"
        back: Any = deserialize(data, cls)
        assert type(back) is cls
        assert flat(back) == flat(message)
        assert serialize(back) == data


@pytest.mark.parametrize("cls", CLASSES, ids=name_of)
def test_every_value_of_every_field_comes_back(cls: type) -> None:
    @quick
    @given(messages_of(cls))
    def check(message: Any) -> None:
        assert flat(deserialize(serialize(message), cls)) == flat(message)

    check()


@given(st.sampled_from(CLASSES), st.data())
def test_a_message_that_comes_back_is_equal_to_the_one_that_was_sent(
    cls: type, data: st.DataObject
) -> None:
    message = data.draw(messages_of(cls))
    back: Any = deserialize(serialize(message), cls)
    if "nan" not in str(flat(message)):
        assert back == message
        assert hash(back) == hash(message)


@pytest.mark.parametrize("cls", CLASSES, ids=name_of)
def test_a_message_has_the_same_bytes_whatever_was_written_before(cls: type) -> None:
    # A writer remembers texts and arrays by their identity.
    choose = Rolled(4)
    few = [made(describe(cls), choose) for _ in range(3)]
    for first, second in product(few, repeat=2):
        names = [one.name for one in describe(cls).fields]
        mixed = [attrs.evolve(second, **{name: getattr(first, name)}) for name in names]
        for message in (first, first, *mixed, second):
            plain = PlainCdr(message)
            assert plain.without_padding(serialize(message)) == plain.data()


@pytest.mark.parametrize("cls", CLASSES, ids=name_of)
def test_bytes_of_the_other_order_are_read(cls: type) -> None:
    choose = Rolled(2)
    for _ in range(20):
        message = made(describe(cls), choose)
        assert flat(deserialize(PlainCdr(message, ">").data(), cls)) == flat(message)


@pytest.mark.parametrize("cls", CLASSES, ids=name_of)
def test_padding_behind_a_message_and_writable_or_foreign_buffers_are_read(cls: type) -> None:
    message = made(describe(cls), Rolled(3))
    data = serialize(message)
    for given_bytes in (
        data + b"\0\0\0",
        bytearray(data),
        memoryview(data),
        memoryview(bytearray(data)),
    ):
        read: Any = given_bytes
        assert flat(deserialize(read, cls)) == flat(message)


@pytest.mark.parametrize("cls", CLASSES, ids=name_of)
def test_bytes_that_change_later_do_not_change_the_message(cls: type) -> None:
    message = made(describe(cls), Rolled(4))
    data: Any = bytearray(serialize(message))
    back: Any = deserialize(data, cls)
    data[:] = b"\xff" * len(data)
    assert flat(back) == flat(message)


def test_a_second_writer_that_follows_the_standard_number_by_number_agrees() -> None:
    choose = Rolled(5)
    for cls in CLASSES:
        message = made(describe(cls), choose)
        assert PlainCdr(message).data() == serialize(message), name_of(cls)


def test_a_number_has_the_size_that_its_width_says() -> None:
    for width, size in SIZES.items():
        digits = "".join(filter(str.isdigit, width.value))
        assert size * 8 == int(digits or 8)


def test_whole_numbers_in_fields_of_floats_are_written_as_floats() -> None:
    for cls in CLASSES:
        message = made(describe(cls), Rolled(6))
        whole, real = _all_floats(message, int), _all_floats(message, float)
        assert serialize(whole) == serialize(real), name_of(cls)


def _all_floats(message: Any, kind: type) -> Any:
    """The message with 1 in each field of floats, whole or real."""
    changes: dict[str, Any] = {}
    for one in describe(type(message)).fields:
        value = getattr(message, one.name)
        if isinstance(one.element, MessageType):
            changed = (
                _all_floats(value, kind)
                if one.kind is Kind.ONE
                else tuple(_all_floats(part, kind) for part in value)
            )
            changes[one.alias] = changed
        elif one.element in (Width.FLOAT32, Width.FLOAT64):
            changes[one.alias] = kind(1) if one.kind is Kind.ONE else (kind(1),) * len(value)
    return attrs.evolve(message, **changes)
