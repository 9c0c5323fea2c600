"""Buffers in messages: kept without a copy, refused with the cure, equal, shown and pickled."""

import copy
import ctypes
import pickle
import tracemalloc
from array import array
from dataclasses import dataclass
from importlib import import_module
from typing import Annotated, Any

import attrs
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.messages import (
    Float32MultiArray,
    Float64MultiArray,
    Image,
    Int8MultiArray,
    Int16MultiArray,
    Int32MultiArray,
    Int64MultiArray,
    LaserScan,
    OccupancyGrid,
    PointCloud2,
    UInt8MultiArray,
    UInt16MultiArray,
    UInt32MultiArray,
    UInt64MultiArray,
)
from rosbase.messages import fields as ros
from rosbase.messages.fields import message
from rosbase.wire import deserialize, serialize

np: Any = import_module("numpy")

PIXELS = bytes(range(250)) * 4


@message("my_msgs/msg/Scan")
@attrs.frozen
class Scan:
    ranges: Annotated[ros.Buffer, ros.Numbers(ros.Width.FLOAT32)] = ros.numbers(ros.Width.FLOAT32)
    corners: Annotated[ros.Buffer, ros.Numbers(ros.Width.INT16), ros.Fixed(4)] = ros.numbers(
        ros.Width.INT16, 4
    )


@message("my_msgs/msg/Blob")
@dataclass(frozen=True)
class Blob:
    data: Annotated[ros.Buffer, ros.Numbers(ros.Width.UINT8)] = b""
    label: str = ""


@message("my_msgs/msg/Later")
@dataclass(frozen=True)
class Later:
    data: "Annotated[ros.Buffer, ros.Numbers(ros.Width.UINT16)]" = ()


def read_only(numbers: Any) -> Any:
    numbers.setflags(write=False)
    return numbers


def view(numbers: Any) -> memoryview:
    return memoryview(numbers).toreadonly()


def with_data(data: Any, kind: Any = Image) -> Any:
    return kind(data=data)


FORMS: list[Any] = [
    PIXELS,
    tuple(PIXELS),
    view(PIXELS),
    view(bytearray(PIXELS)),
    view(array("B", PIXELS)),
    read_only(np.frombuffer(PIXELS, np.uint8)),
    read_only(np.frombuffer(PIXELS, np.uint8).reshape(10, 25, 4).copy()),
]


@pytest.mark.parametrize("form", FORMS, ids=lambda form: type(form).__name__)
def test_a_buffer_that_nobody_can_change_is_kept_without_a_copy(form: Any) -> None:
    image = with_data(form)
    assert image.data is form
    assert serialize(image) == serialize(Image(data=PIXELS))


def test_equality_and_hash_go_by_the_numbers_whatever_holds_them() -> None:
    images = [with_data(form) for form in FORMS]
    assert len(set(images)) == 1
    for image in images:
        assert image == images[0]
        assert image != Image(data=PIXELS[:-1])
        assert image != Image(data=PIXELS, height=1)
    scans = [
        Scan((1.5, float("nan"), 3)),
        Scan(view(array("f", (1.5, float("nan"), 3)))),
        Scan(read_only(np.array([1.5, float("nan"), 3], np.float32))),
    ]
    assert len(set(scans)) == 1
    assert scans[0] == scans[1] == scans[2] != Scan((1.5,))


@pytest.mark.parametrize(
    "empty",
    [(), b"", view(b""), read_only(np.empty(0, np.uint8)), read_only(np.empty((0, 4), "B"))],
)
def test_all_empty_buffers_are_equal_and_written(empty: Any) -> None:
    assert with_data(empty) == Image()
    assert serialize(with_data(empty)) == serialize(Image())
    assert pickle.loads(pickle.dumps(with_data(empty))) == Image()


def test_a_tuple_of_something_else_is_only_equal_to_itself() -> None:
    for wrong in ((None,), (256,), (-1,), ("a",), (1.5,)):
        assert with_data(wrong) == with_data(wrong)
        assert with_data(wrong) != Image()


CAN_BE_CHANGED = (
    r"^data takes a buffer that nobody can change: use bytes\(\.\.\.\),"
    r" memoryview\(\.\.\.\)\.toreadonly\(\), or array\.setflags\(write=False\) of numpy$"
)


@pytest.mark.parametrize(
    ("kind", "data", "error"),
    [
        (Image, bytearray(PIXELS), CAN_BE_CHANGED),
        (Image, array("B", PIXELS), CAN_BE_CHANGED),
        (Image, memoryview(bytearray(PIXELS)), CAN_BE_CHANGED),
        (Image, np.zeros(4, np.uint8), CAN_BE_CHANGED),
        (Image, (ctypes.c_uint8 * 4)(), CAN_BE_CHANGED),
        (
            Image,
            view(PIXELS)[::2],
            r"^data takes a contiguous buffer: use numpy\.ascontiguousarray",
        ),
        (
            Image,
            read_only(np.zeros((4, 4), np.uint8)).T[1:],
            r"^data takes a contiguous buffer: use numpy\.ascontiguousarray\(\.\.\.\)$",
        ),
        (Image, read_only(np.zeros(4)), r"^data takes uint8 numbers, not those of the format 'd'"),
        (Float32MultiArray, read_only(np.zeros(4)), r"^data takes float32 numbers, not "),
        (Float64MultiArray, b"12345678", r"^data takes numbers of another width than bytes have$"),
        (Int8MultiArray, b"1", r"^data takes numbers of another width than bytes have$"),
        (OccupancyGrid, read_only(np.zeros(4, np.uint8)), r"^data takes int8 numbers, not "),
        (
            Float64MultiArray,
            read_only(np.zeros(4, ">f8")),
            r"^data takes float64 numbers, not those of the format '>d'",
        ),
        (
            Int32MultiArray,
            read_only(np.zeros(4, np.int64)),
            r"^data takes int32 numbers, .* '[lq]': use array\.astype\(numpy\.int32\)$",
        ),
        (UInt32MultiArray, view(array("Q", (1, 2))), r"^data takes uint32 numbers, not "),
        (Int64MultiArray, view(array("i", (1, 2))), r"^data takes int64 numbers, not "),
        (PointCloud2, [1, 2, 3], r"^data takes a tuple or a read-only buffer, not list$"),
        (PointCloud2, "text", r"^data takes a tuple or a read-only buffer, not str$"),
        (PointCloud2, None, r"^data takes a tuple or a read-only buffer, not NoneType$"),
    ],
)
def test_other_buffers_are_refused_with_the_cure(kind: Any, data: Any, error: str) -> None:
    with pytest.raises(TypeError, match=error):
        kind(data=data)
    with pytest.raises(TypeError, match=error):
        attrs.evolve(kind(), data=data)


ARRAYS: list[Any] = [
    *(Int8MultiArray, Int16MultiArray, Int32MultiArray, Int64MultiArray, Float32MultiArray),
    *(UInt8MultiArray, UInt16MultiArray, UInt32MultiArray, UInt64MultiArray, Float64MultiArray),
]
FORMATS = [*"?bBhHiIlLqQefdgD", "<i4", ">i4", ">u8", ">f4", "S1", "U1", "O", "M8[s]"]


@pytest.mark.parametrize("kind", ARRAYS, ids=lambda kind: str(kind.__name__))
@given(form=st.sampled_from(FORMATS), numbers=st.lists(st.integers(0, 9), max_size=4))
def test_an_array_of_other_numbers_is_refused_and_never_written_as_different_ones(
    kind: Any, form: str, numbers: list[int]
) -> None:
    numbers_of_form = read_only(np.array(numbers, np.uint8).astype(form))
    try:
        sent = kind(data=numbers_of_form)
    except TypeError:
        return
    back = deserialize(serialize(sent), kind)
    assert list(back.data) == numbers
    assert back == sent


@message("my_msgs/msg/Bare")
@attrs.frozen
class Bare:
    data: Annotated[ros.Buffer, ros.Numbers(ros.Width.UINT8)] = b""
    other: float = attrs.field(default=0.0, eq=False)


@message("my_msgs/msg/Switches")
@attrs.frozen
class Switches:
    data: Annotated[ros.Buffer, ros.Numbers(ros.Width.BOOL)] = ros.numbers(ros.Width.BOOL)


@message("my_msgs/msg/Ranges")
@dataclass(frozen=True)
class Ranges:
    data: Annotated[ros.Buffer, ros.Numbers(ros.Width.FLOAT32), ros.Fixed(2)] = (0.0, 0.0)


@pytest.mark.parametrize("kind", [Blob, Bare])
@pytest.mark.parametrize("form", FORMS, ids=lambda form: type(form).__name__)
def test_a_buffer_of_a_dataclass_or_without_a_field_of_numbers_is_compared_by_its_bytes(
    kind: Any, form: Any
) -> None:
    one = kind(form)
    assert one.data is form
    assert one == kind(PIXELS)
    assert hash(one) == hash(kind(PIXELS))
    assert deserialize(serialize(one), kind) == one
    assert one != kind(PIXELS[1:])
    assert one != Image(data=PIXELS)


@pytest.mark.parametrize("kind", [Blob, Bare])
def test_such_a_buffer_is_refused_if_it_can_be_changed(kind: Any) -> None:
    for wrong in (bytearray(4), np.zeros(4, np.uint8), [1, 2]):
        with pytest.raises(TypeError, match=r"^data takes a "):
            kind(wrong)
        with pytest.raises(TypeError, match=r"^data takes a "):
            kind(data=wrong)
    with pytest.raises(TypeError, match=r"^data takes uint16 numbers"):
        Later(read_only(np.zeros(4)))
    with pytest.raises(ValueError, match=r"^data takes 2 elements, not 3$"):
        Ranges((1.0, 2.0, 3.0))
    assert Ranges((1.0, 2.0)) == Ranges(read_only(np.array([1, 2], np.float32)))


def test_fields_that_a_class_does_not_compare_stay_out_of_the_comparison() -> None:
    assert Bare(b"1", 1.0) == Bare(b"1", 2.0)
    assert Blob(b"1", "a") != Blob(b"1", "b")

    @message("my_msgs/msg/Counted")
    @dataclass(frozen=True)
    class Counted:
        data: Annotated[ros.Buffer, ros.Numbers(ros.Width.UINT8)] = b""

        def __eq__(self, other: object) -> bool:
            return isinstance(other, Counted)

        def __hash__(self) -> int:
            return 1

    assert Counted(b"1") == Counted(b"2")


@pytest.mark.parametrize(
    "form", [(True, False), view(bytes((1, 0))).cast("?"), read_only(np.array([True, False]))]
)
def test_a_buffer_of_switches_is_equal_after_its_way_through_bytes(form: Any) -> None:
    back = deserialize(serialize(Switches(form)), Switches)
    assert back == Switches(form) == Switches((True, False))
    assert hash(back) == hash(Switches(form))
    assert back != Switches((True, True))


def test_the_cures_work() -> None:
    numbers = np.arange(8, dtype=np.uint8)
    crop = numbers.reshape(2, 4)[:, 1:3]
    numbers.setflags(write=False)
    assert Image(data=numbers).data is numbers
    assert Image(data=bytes(bytearray(b"12"))).data == b"12"
    assert Image(data=memoryview(bytearray(b"12")).toreadonly()).data == b"12"
    contiguous = np.ascontiguousarray(crop)
    contiguous.setflags(write=False)
    assert Image(data=contiguous) == Image(data=(1, 2, 5, 6))


@pytest.mark.parametrize(
    "corners", [(1, 2, 3, 4), view(array("h", (1, 2, 3, 4))), read_only(np.ones((2, 2), np.int16))]
)
def test_a_buffer_of_a_fixed_size_counts_its_numbers(corners: Any) -> None:
    assert deserialize(serialize(Scan(corners=corners)), Scan) == Scan(corners=corners)
    with pytest.raises(ValueError, match=r"^corners takes 4 elements, not 3$"):
        Scan(corners=corners[:3] if len(corners) == 4 else read_only(np.ones((1, 3), np.int16)))


@pytest.mark.parametrize("form", FORMS, ids=lambda form: type(form).__name__)
def test_a_message_with_many_numbers_is_shown_in_one_short_line(form: Any) -> None:
    shown = repr(with_data(form))
    assert shown.endswith("data=<1000 elements>)")
    assert len(shown) < 250
    assert repr(Image(data=b"12")).endswith("data=b'12')")
    assert repr(LaserScan(ranges=(1.0, 2.0))).endswith("ranges=(1.0, 2.0), intensities=())")


# Before 2, Python pickles no class with slots.
@pytest.mark.parametrize("protocol", range(2, pickle.HIGHEST_PROTOCOL + 1))
@pytest.mark.parametrize(
    "original",
    [
        *map(with_data, FORMS),
        *(Blob(form, "x") for form in FORMS),
        Scan(read_only(np.ones(3, np.float32)), view(array("h", (1, 2, 3, 4)))),
        Later(view(array("H", (1, 2)))),
        Later((1, 2)),
    ],
)
def test_a_message_is_pickled_whatever_its_buffer_is(original: Any, protocol: int) -> None:
    back = pickle.loads(pickle.dumps(original, protocol))
    assert type(back) is type(original)
    assert serialize(back) == serialize(original)
    for name in ("data", "ranges", "corners"):
        before: Any = getattr(original, name, ())
        after: Any = getattr(back, name, ())
        assert type(before) is type(after)
        if not isinstance(after, tuple):
            assert memoryview(after).readonly
            assert memoryview(after).format == memoryview(before).format
            assert memoryview(after).shape == memoryview(before).shape


@pytest.mark.parametrize("form", FORMS, ids=lambda form: type(form).__name__)
def test_a_message_is_copied(form: Any) -> None:
    for original in (with_data(form), Blob(form)):
        assert copy.copy(original) is original
        deep = copy.deepcopy(original)
        assert serialize(deep) == serialize(original)
        assert type(deep.data) is type(form)


def test_a_message_that_was_read_can_be_pickled() -> None:
    for original in (Image(data=PIXELS), LaserScan(ranges=(1.0, 2.0)), Blob(PIXELS)):
        read: Any = deserialize(serialize(original), type(original))
        assert pickle.loads(pickle.dumps(read)) == read
        assert copy.deepcopy(read) == read


def test_pickling_copies_a_large_buffer_only_into_the_pickle() -> None:
    large = view(bytes(5_000_000))
    image = Image(data=large)
    pickle.dumps(image, pickle.HIGHEST_PROTOCOL)
    tracemalloc.start()
    try:
        data = pickle.dumps(image, pickle.HIGHEST_PROTOCOL)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert len(data) < peak < 2.5 * len(data)
    assert image.data is large


def test_a_large_buffer_is_written_with_one_copy_and_read_without_any() -> None:
    image = Image(data=view(bytes(5_000_000)))
    data = serialize(image)
    # The first read of a type compiles its reader.
    deserialize(data, Image)
    tracemalloc.start()
    try:
        serialize(image)
        _, written = tracemalloc.get_traced_memory()
        tracemalloc.reset_peak()
        pixels: Any = deserialize(data, Image).data
        _, read = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert written < 5_100_000
    assert read < 100_000
    assert pixels.readonly
    with pytest.raises(TypeError):
        pixels[0] = 1


def test_numpy_sees_the_numbers_of_a_message_that_was_read_without_a_copy() -> None:
    data = serialize(LaserScan(ranges=(1.0, 2.0, 3.0)))
    ranges = np.asarray(deserialize(data, LaserScan).ranges)
    assert ranges.dtype == np.float32
    assert ranges.tolist() == [1.0, 2.0, 3.0]
    assert not ranges.flags.writeable
    assert np.shares_memory(ranges, np.frombuffer(data, np.uint8))
