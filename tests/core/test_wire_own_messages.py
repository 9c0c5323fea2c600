"""Messages of one's own: an attrs class or a dataclass with one decorator."""

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from typing import Annotated, Any, ClassVar, NamedTuple

import attrs
import pytest
from hypothesis import given

from rosbase.errors import WireError
from rosbase.messages import Header, Point, Vector3
from rosbase.messages import fields as ros
from rosbase.messages.fields import message
from rosbase.wire import dds_type_name, deserialize, schema, serialize, type_hash
from rosbase.wire.description import describe
from support.plain_cdr import PlainCdr
from support.wire_messages import flat, messages_of


@message("my_msgs/msg/Finger")
@dataclass(frozen=True)
class Finger:
    force: ros.Float32 = 0.0
    is_closed: bool = False


@message("my_msgs/msg/Grip")
@attrs.frozen
class Grip:
    """All that a message can have."""

    OPEN: ClassVar[ros.UInt8] = 0
    CLOSED: ClassVar[ros.UInt8] = 1
    NAME: ClassVar[str] = "gripper"
    not_a_constant: ClassVar[list[int]] = []

    header: Header = Header()
    state: ros.UInt8 = 0
    count: ros.Int64 = 0
    width: float = 0.0
    name: Annotated[str, ros.AtMost(10)] = ""
    label: ros.WString = ""
    tips: tuple[Point, Point] = (Point(), Point())
    fingers: tuple[Finger, ...] = ()
    few: Annotated[tuple[Finger, ...], ros.AtMost(2)] = ()
    joints: Annotated[tuple[ros.Int16, ...], ros.Fixed(3)] = (0, 0, 0)
    words: Annotated[tuple[Annotated[str, ros.AtMost(4)], ...], ros.AtMost(3)] = ()
    depths: Annotated[ros.Buffer, ros.Numbers(ros.Width.UINT16)] = ros.numbers(ros.Width.UINT16)
    on: tuple[bool, ...] = ()


@message("my_msgs/msg/Slotted")
@dataclass(frozen=True, slots=True, kw_only=True)
class Slotted:
    inner: Grip = Grip()
    raw: bytes = field(default=b"", init=False)


@message("my_msgs/msg/Named")
@attrs.frozen(kw_only=True, slots=False)
class Named:
    _private: ros.UInt32 = 0
    other: ros.Char = 0


OWN = [Finger, Grip, Slotted, Named]


@pytest.mark.parametrize("cls", OWN)
def test_an_own_message_becomes_bytes_and_itself_again(cls: type) -> None:
    @given(messages_of(cls))
    def check(sent: Any) -> None:
        data = serialize(sent)
        assert data == PlainCdr(sent).data()
        back: Any = deserialize(data, cls)
        assert type(back) is cls
        assert flat(back) == flat(sent)
        assert flat(deserialize(PlainCdr(sent, ">").data(), cls)) == flat(sent)

    check()


def test_the_schema_has_constants_fields_and_the_messages_within_each_once() -> None:
    rule = "=" * 80
    assert schema(Slotted) == "\n".join(
        [
            "my_msgs/Grip inner",
            rule,
            "MSG: my_msgs/Grip",
            "uint8 OPEN=0",
            "uint8 CLOSED=1",
            'string NAME="gripper"',
            "std_msgs/Header header",
            "uint8 state",
            "int64 count",
            "float64 width",
            "string<=10 name",
            "wstring label",
            "geometry_msgs/Point[2] tips",
            "my_msgs/Finger[] fingers",
            "my_msgs/Finger[<=2] few",
            "int16[3] joints",
            "string<=4[<=3] words",
            "uint16[] depths",
            "bool[] on",
            rule,
            "MSG: std_msgs/Header",
            "builtin_interfaces/Time stamp",
            "string frame_id",
            rule,
            "MSG: builtin_interfaces/Time",
            "int32 sec",
            "uint32 nanosec",
            rule,
            "MSG: geometry_msgs/Point",
            "float64 x",
            "float64 y",
            "float64 z",
            rule,
            "MSG: my_msgs/Finger",
            "float32 force",
            "bool is_closed",
            "",
        ]
    )


def test_the_names_and_the_hash_are_those_of_ros() -> None:
    @message("geometry_msgs/msg/Vector3")
    @dataclass(frozen=True)
    class Mine:
        x: float = 0.0
        y: float = 0.0
        z: float = 0.0

    assert type_hash(Mine) == type_hash(Vector3)
    assert schema(Mine) == schema(Vector3)
    assert dds_type_name(Grip) == "my_msgs::msg::dds_::Grip_"
    assert serialize(Mine(1.0, 2.0, 3.0)) == serialize(Vector3(1.0, 2.0, 3.0))


def test_a_service_message_keeps_its_kind_in_the_schema() -> None:
    @message("my_msgs/srv/Go_Request")
    @attrs.frozen
    class Request:
        speed: float = 0.0

    @message("my_msgs/msg/Whole")
    @attrs.frozen
    class Whole:
        request: Request = Request()

    assert schema(Whole) == (
        f"my_msgs/srv/Go_Request request\n{'=' * 80}\nMSG: my_msgs/srv/Go_Request\nfloat64 speed\n"
    )


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (Grip(name="x" * 11), "Grip.name takes at most 10 bytes of text, not 11"),
        (Grip(name="ä" * 6), "Grip.name takes at most 10 bytes of text, not 12"),
        (Grip(words=("a",) * 4), "Grip.words takes at most 3 elements, not 4"),
        (Grip(words=("abcde",)), "Grip.words takes at most 4 bytes of text, not 5"),
        (Grip(few=(Finger(),) * 3), "Grip.few takes at most 2 elements, not 3"),
        (Grip(joints=(1, 2)), "Grip.joints takes 3 elements, not 2"),
        (Grip(joints=(1, 2, 40_000)), "Grip.joints takes whole numbers from -32768 to 32767"),
        (Grip(tips=(Point(),)), "Grip.tips takes 2 elements, not 1"),  # type: ignore[arg-type]  # the mistake is the test
        (Grip(fingers=(Finger(None),)), "Grip.fingers.force takes numbers, not None"),  # type: ignore[arg-type]  # the mistake is the test
        (Slotted(inner=None), "Slotted.inner takes messages of type Grip, not None"),  # type: ignore[arg-type]  # the mistake is the test
        (Slotted(inner=Grip(state=300)), "Slotted.inner.state takes whole numbers from 0 to 255"),
    ],
)
def test_a_wrong_value_is_refused_by_the_name_of_its_field(wrong: Any, text: str) -> None:
    with pytest.raises((TypeError, ValueError)) as caught:
        serialize(wrong)
    assert str(caught.value) == text


def test_two_arrays_whose_lengths_make_up_for_each_other_are_refused() -> None:
    @message("my_msgs/msg/Two")
    @attrs.frozen
    class Two:
        left: Annotated[tuple[float, ...], ros.Fixed(2)] = (0.0, 0.0)
        right: Annotated[tuple[float, ...], ros.Fixed(2)] = (0.0, 0.0)

    for wrong in (Two((1.0,), (1.0, 2.0, 3.0)), Two((1.0, 2.0, 3.0), (1.0,))):
        with pytest.raises(ValueError, match=r"^Two\.left takes 2 elements, not [13]$"):
            serialize(wrong)


@pytest.mark.parametrize(("name", "many"), [(None, (0.0, 0.0)), ("", None)])
def test_nothing_is_no_value_of_the_first_message_of_a_type(name: Any, many: Any) -> None:
    # Its writer has no text and no array to remember yet.
    @message("my_msgs/msg/First")
    @attrs.frozen
    class First:
        name: str = ""
        many: Annotated[tuple[float, ...], ros.Fixed(2)] = (0.0, 0.0)

    with pytest.raises(TypeError, match="not None"):
        serialize(First(name, many))


def test_a_bounded_wide_text_counts_units_whatever_else_is_unusual() -> None:
    @message("my_msgs/msg/Wide")
    @attrs.frozen
    class Wide:
        text: Annotated[ros.WString, ros.AtMost(3)] = ""
        number: float = 0.0

    for text in ("ééé", "雪雪雪", "a🧭"):
        for number in (1.0, 1):
            assert deserialize(serialize(Wide(text, number)), Wide) == Wide(text, 1.0)
    with pytest.raises(
        ValueError, match=r"^Wide\.text takes at most 3 UTF-16 units of text, not 4"
    ):
        serialize(Wide("🧭🧭"))


def test_a_class_that_checks_its_fields_refuses_bytes_as_a_wire_error() -> None:
    @message("my_msgs/msg/Checked")
    @attrs.frozen
    class Checked:
        speed: float = attrs.field(default=0.0, validator=attrs.validators.ge(0.0))

    @message("my_msgs/msg/Unchecked")
    @attrs.frozen
    class Unchecked:
        speed: float = 0.0

    @message("my_msgs/msg/Asserted")
    @attrs.frozen
    class Asserted:
        speed: float = 0.0

        def __attrs_post_init__(self) -> None:
            assert self.speed >= 0.0, "too\nslow"

    with pytest.raises(WireError, match=r"^my_msgs/msg/Checked: "):
        deserialize(serialize(Unchecked(-1.0)), Checked)
    with pytest.raises(WireError, match=r"^my_msgs/msg/Asserted: AssertionError: too slow"):
        deserialize(serialize(Unchecked(-1.0)), Asserted)


class Mutable:
    pass


class Pair(NamedTuple):
    x: float


class Color(Enum):
    RED = 1


@dataclass
class MutableData:
    x: float = 0.0


@attrs.define
class MutableAttrs:
    x: float = 0.0


@attrs.define
class MutableHooked:
    x: float = attrs.field(default=0.0, converter=float)


@pytest.mark.parametrize(
    "cls", [Mutable, MutableData, MutableAttrs, MutableHooked, Pair, Color, int]
)
def test_a_class_that_is_not_frozen_is_refused_with_the_cure(cls: type) -> None:
    cure = "make it a frozen attrs class or a frozen dataclass, below this decorator$"
    with pytest.raises(TypeError, match=rf"^{cls.__name__} .*; {cure}"):
        message("my_msgs/msg/Name")(cls)


@pytest.mark.parametrize(
    "name",
    [
        None,
        int,
        "",
        "Grip",
        "my_msgs/Grip",
        "my_msgs/msg/",
        "my_msgs/msg/a-b",
        "a/b/c",
        "a/msg/b/c",
    ],
)
def test_a_name_of_another_form_is_refused(name: Any) -> None:
    with pytest.raises(ValueError, match=r"^a message is named like sensor_msgs/msg/Imu, not "):
        message(name)


def declared(annotation: Any) -> type:
    cls = dataclasses.make_dataclass("Own", [("part", annotation)], frozen=True)
    return message("my_msgs/msg/Own")(cls)


@pytest.mark.parametrize(
    ("annotation", "why"),
    [
        (int, "say how wide the number is, such as Int32 or UInt8"),
        (tuple[int, ...], "say how wide the number is, such as Int32 or UInt8"),
        (list[float], r"list\[float\] is no type of ROS"),
        (dict, "<class 'dict'> is no type of ROS"),
        (Any, r"typing\.Any is no type of ROS"),
        (Pair, ".*Pair'> is no type of ROS"),
        (float | None, r"float \| None is no type of ROS"),
        (tuple[float, str], "an array of ROS has elements of one type"),
        (tuple[Finger, Point], "an array of ROS has elements of one type"),
        (bytes, "<class 'bytes'> is no type of ROS"),
    ],
)
@pytest.mark.parametrize("use", [describe, schema, type_hash, lambda cls: serialize(cls(None))])
def test_a_field_without_a_type_of_ros_is_refused_by_its_name(
    annotation: Any, why: str, use: Callable[[type], object]
) -> None:
    cls = declared(annotation)
    with pytest.raises(TypeError, match=rf"^Own\.part: {why}$"):
        use(cls)


@message("my_msgs/msg/Chain")
@attrs.frozen
class Chain:
    links: "tuple[Chain, ...]" = ()


@message("my_msgs/msg/Hen")
@attrs.frozen
class Hen:
    eggs: "tuple[Egg, ...]" = ()


@message("my_msgs/msg/Egg")
@attrs.frozen
class Egg:
    hen: Hen = Hen()


@message("my_msgs/msg/Late")
@attrs.frozen
class Late:
    data: "Unknown" = 0  # type: ignore[name-defined]  # noqa: F821 - the mistake is the test


@pytest.mark.parametrize(
    ("cls", "why"),
    [
        (Chain, r"Chain\.links: a message of ROS does not contain itself"),
        (Egg, r"Hen\.eggs: a message of ROS does not contain itself"),
        (Hen, r"Egg\.hen: a message of ROS does not contain itself"),
        (declared(tuple[()]), r"Own\.part: an array of ROS has elements"),
        (
            Late,
            r"Late: an annotation cannot be read: name 'Unknown' is not defined; declare the"
            r" message at the top of a module, or leave out `from __future__ import annotations`",
        ),
    ],
    ids=str,
)
def test_a_class_that_cannot_be_described_is_refused_in_one_line(cls: type, why: str) -> None:
    for _ in range(2):
        with pytest.raises(TypeError, match=f"^{why}$"):
            describe(cls)


def test_a_text_among_the_constants_stays_on_its_line_of_the_schema() -> None:
    @message("my_msgs/msg/Quoted")
    @attrs.frozen
    class Quoted:
        NAME: ClassVar[str] = 'a "b"\nuint8 c'

    assert schema(Quoted) == r'string NAME="a \"b\"\nuint8 c"' + "\n"


def test_a_class_without_the_decorator_is_refused_with_the_cure() -> None:
    for use in (describe, schema, type_hash, dds_type_name):
        with pytest.raises(
            TypeError, match=r"^MutableData is no message: decorate it with @messag"
        ):
            use(MutableData)
    with pytest.raises(TypeError, match=r"^Own\.part: .*MutableData'> is no type of ROS$"):
        describe(declared(MutableData))
