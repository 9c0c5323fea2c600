"""Hypothesis strategies: their one home."""

import json
import math
from typing import NamedTuple

from hypothesis import strategies as st

from rosbase.fsm import ANY
from rosbase.lifecycle import TRANSITIONS, CallbackReturn
from rosbase.messages import (
    Bool,
    DiagnosticArray,
    DiagnosticStatus,
    Header,
    Imu,
    JointState,
    Joy,
    KeyValue,
    MagneticField,
    Point,
    PointStamped,
    Pose,
    PoseStamped,
    Quaternion,
    String,
    Time,
    Twist,
    Vector3,
)
from rosbase.processes.mark import Mark
from rosbase.qos import DurabilityPolicy, HistoryPolicy, QoSProfile

answers = st.sampled_from(CallbackReturn)

labels = st.sampled_from(sorted({t.label for t in TRANSITIONS})) | st.text(max_size=12)

transition_ids = st.integers(-5, 110)

# Everything that Python's json can decode to, NaN and huge numbers included.
json_values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.sampled_from([10**400, -(10**400), 2**53 + 1])
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["1.5", "-0", "1e999", "nan", "1_0", "N/A"]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=4), inner),
    max_leaves=12,
)

# What somebody might choose who wants to write on another's terminal.
outside_texts = st.lists(
    st.text(max_size=20)
    | st.sampled_from(
        [
            "\x1b[2J", "\x1b]0;title\x07", "\x9b1m", "\r", "\n", "\r\n", "\v", "\f", "\x85",
            "\u2028", "\u2029", "\u202a", "\u202e", "\u2066", "\u2069", "\u200e", "\u200f",
            "\u061c", "\ufeff", "\u200b", "\udcff", "\ud800", "\0", "\x7f", "\t", "\xa0",
            "\U000e0041", "\\n", "ä", "雪",
        ]
    ),
    max_size=30,
).map("".join)  # fmt: skip

numbers = st.floats(-1e6, 1e6) | st.integers(-1000, 1000)


def vectors(values: st.SearchStrategy[object], axes: str = "xyz") -> st.SearchStrategy[object]:
    """Objects with some or all of the axes, or something else altogether."""
    whole = st.fixed_dictionaries(dict.fromkeys(axes, values))
    partial = st.dictionaries(st.sampled_from([*axes, "other"]), values)
    return whole | partial | json_values


# Payloads of the default shape, good and bad, that look like what a device might send.
payloads = st.fixed_dictionaries(
    {},
    optional={
        "orientation": vectors(numbers | json_values, "xyzw"),
        "angular_velocity": vectors(numbers | json_values),
        "linear_acceleration": vectors(numbers | json_values),
        "header": json_values,
        "extra": json_values,
    },
)

# Within the full scale of every quantity.
reals = st.floats(-60.0, 60.0) | st.integers(-60, 60)


@st.composite
def good_payloads(draw: st.DrawFn) -> dict[str, object]:
    """Payloads of the default shape that must become samples."""
    payload: dict[str, object] = {
        name: {axis: draw(reals) for axis in "xyz"}
        for name in ("angular_velocity", "linear_acceleration")
    }
    direction = [draw(st.floats(-1, 1)) for _ in "xyzw"]
    norm = math.hypot(*direction)
    if norm > 0.1 and draw(st.booleans()):
        # As firmware rounds it: to a few digits.
        digits = draw(st.integers(2, 9))
        unit = [round(number / norm, digits) for number in direction]
        payload["orientation"] = dict(zip("xyzw", unit, strict=True))
    if draw(st.booleans()):
        payload["header"] = {"stamp": {"sec": draw(st.integers(0, 2**32)), "nanosec": 5}}
    return payload


# Every orientation, as x, y, z, w.
unit_quaternions = (
    st.tuples(*[st.floats(-1.0, 1.0)] * 4)
    .filter(lambda q: math.hypot(*q) > 0.1)
    .map(lambda q: tuple(axis / math.hypot(*q) for axis in q))
)

frames = st.binary(max_size=200) | (payloads | good_payloads() | json_values).map(
    lambda p: json.dumps(p).encode()
)


FSM_STATES = ("a", "b", "c", "d")
FSM_EVENTS = ("x", "y")

# Rows of a task state machine: sources, target, event, whether there is a guard.
FsmRow = tuple[str | tuple[str, ...], str, str | None, bool]


@st.composite
def fsm_tables(draw: st.DrawFn) -> list[FsmRow]:
    """Tables that begin at "a" and in which every row can be taken."""
    states, events = st.sampled_from(FSM_STATES), st.sampled_from([None, *FSM_EVENTS])
    sources = states | st.lists(states, min_size=1, unique=True).map(tuple) | st.just(ANY)
    table: list[FsmRow] = [("a", "b", None, True)]
    closed: set[tuple[str, str | None]] = set()
    for row in draw(st.lists(st.tuples(sources, states, events, st.booleans()), max_size=10)):
        source, target, event, guarded = row
        left = set(source) if source != ANY else set(FSM_STATES) - {target}
        open_here = {(state, event) for state in left} - closed
        if len(open_here) == len(left):
            table.append(row)
            closed |= set() if guarded else open_here
    return table


fsm_truths = st.lists(st.booleans(), min_size=11, max_size=11)

# What happens to a task state machine: a step, an event, or a state set by somebody else;
# and which guards hold then.
fsm_happenings = st.lists(
    st.tuples(
        st.just(("step", ""))
        | st.sampled_from(FSM_EVENTS).map(lambda event: ("send", event))
        | st.sampled_from(FSM_STATES).map(lambda state: ("set", state)),
        fsm_truths,
    ),
    max_size=30,
)

# Messages with whatever ROS can send: every number that its field holds, NaN included, and
# every text without NUL.
texts = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=20)
int32s = st.integers(-(2**31), 2**31 - 1)
covariances = st.tuples(*[st.floats()] * 9)


def tuples(elements: st.SearchStrategy[object]) -> st.SearchStrategy[tuple[object, ...]]:
    """Short tuples of any length."""
    return st.lists(elements, max_size=4).map(tuple)


times = st.builds(Time, int32s, st.integers(0, 2**32 - 1))
headers = st.builds(Header, times, texts)
vector3s = st.builds(Vector3, *[st.floats()] * 3)
quaternions = st.builds(Quaternion, *[st.floats()] * 4)
points = st.builds(Point, *[st.floats()] * 3)
poses = st.builds(Pose, points, quaternions)
key_values = st.builds(KeyValue, texts, texts)
statuses = st.builds(DiagnosticStatus, st.integers(0, 255), texts, texts, texts, tuples(key_values))
many_floats = tuples(st.floats())

messages: dict[type, st.SearchStrategy[object]] = {
    Bool: st.builds(Bool, st.booleans()),
    DiagnosticArray: st.builds(DiagnosticArray, headers, tuples(statuses)),
    DiagnosticStatus: statuses,
    Header: headers,
    Imu: st.builds(
        Imu, headers, quaternions, covariances, vector3s, covariances, vector3s, covariances
    ),
    JointState: st.builds(
        JointState, headers, tuples(texts), many_floats, many_floats, many_floats
    ),
    Joy: st.builds(Joy, headers, tuples(st.floats(width=32)), tuples(int32s)),
    KeyValue: key_values,
    MagneticField: st.builds(MagneticField, headers, vector3s, covariances),
    Point: points,
    PointStamped: st.builds(PointStamped, headers, points),
    Pose: poses,
    PoseStamped: st.builds(PoseStamped, headers, poses),
    Quaternion: quaternions,
    String: st.builds(String, texts),
    Time: times,
    Twist: st.builds(Twist, vector3s, vector3s),
    Vector3: vector3s,
}

qos_profiles = st.builds(
    QoSProfile,
    st.integers(1, 4),
    durability=st.sampled_from(DurabilityPolicy),
    history=st.sampled_from(HistoryPolicy),
)

QosStep = QoSProfile | int | None
"""Somebody subscribes; the first or the second publisher publishes; all callbacks are run."""

qos_steps: st.SearchStrategy[list[QosStep]] = st.lists(
    st.one_of(qos_profiles, st.integers(0, 1), st.integers(0, 1), st.none()), max_size=40
)

# Passwords as people put them into addresses, with whatever cuts an address short; long enough
# not to stand in a message by chance.
mqtt_secrets = st.text(
    st.characters(codec="utf-8", exclude_categories=["Cc", "Zs"]), min_size=8, max_size=20
)

_numbers = st.integers(0, 2**31)

child_marks = st.builds(
    Mark,
    label=st.integers(1 << 60, (1 << 61) - 1),
    manager=st.tuples(_numbers, _numbers),
    program=st.integers(0, 2**32 - 1).map("{:08x}".format),
    name=st.text(st.characters(codec="utf-8")),
)


class DateEvent(NamedTuple):
    """A sample of a device with a clock: what becomes of it, and what should."""

    kind: str
    """`good`, `duplicate` or `outlier`."""
    x: float
    """What is measured; each good sample has its own."""
    date_ns: int
    arrived_ns: int
    run: int
    """How often the device's clock was set before."""
    since_step: int
    """Good samples since then."""
    since_step_ns: int
    """Nanoseconds since then."""


@st.composite
def date_streams(draw: st.DrawFn) -> list[DateEvent]:
    """Samples in the order of their arrival, of a clock that is set now and then."""
    second = 1_000_000_000
    now_ns = 1_780_000_000 * second
    ahead_ns = draw(st.integers(-20 * 3600 * second, 20 * 3600 * second))
    period_ns = draw(st.sampled_from([5, 10, 50, 100, 1000])) * 1_000_000
    events: list[DateEvent] = []
    wild_days = iter(draw(st.permutations(range(2, 130))))
    run = since_step = x = 0
    step_ns = now_ns
    kinds = st.sampled_from(["good"] * 12 + ["duplicate", "outlier", "outlier", "step"])
    for kind in draw(st.lists(kinds, min_size=1, max_size=120)):
        if kind == "step":
            ahead_ns += draw(st.sampled_from([-1, 1])) * draw(st.integers(3, 10**6)) * second
            run, since_step, step_ns = run + 1, 0, now_ns
            continue
        good = [event for event in events if event.kind == "good"]
        if kind == "duplicate" and good:
            events.append(good[-1]._replace(kind=kind, arrived_ns=now_ns))
            continue
        now_ns += period_ns
        if kind == "outlier":
            if [event.kind for event in events if event.kind != "duplicate"][-1:] == ["outlier"]:
                continue
            # No two agree, or they would be a clock of their own.
            days = next(wild_days) * draw(st.sampled_from([-1, 1]))
            date_ns = now_ns + ahead_ns + days * 86_400 * second
            if abs(date_ns - now_ns) <= 86_400 * second:
                # By chance it is nearer to the truth than the clock.
                continue
        else:
            x += 1
            delay_ns = draw(st.integers(0, period_ns // 2))
            date_ns = now_ns + ahead_ns - delay_ns
        events.append(DateEvent(kind, x, date_ns, now_ns, run, since_step, now_ns - step_ns))
        since_step += kind != "outlier"
    return events


class MadeRead(NamedTuple):
    """What a reader finds, and what has become of the clocks since the read before."""

    pause_ns: int
    """Time since the read before."""
    looks: bool
    """Whether the reader looked in vain shortly before; if not, it stood still."""
    frames: int
    """How many frames the read completes."""
    begins: bool
    """Whether another frame is begun and not completed."""
    step_ns: int
    """By how much the date was set in the pause."""
    held_ns: tuple[int, int]
    """For how long somebody else had the processor before and after the date was read."""


_pauses_ns = st.one_of(
    st.integers(10_000, 1_000_000),
    st.integers(1_000_000, 50_000_000),
    st.integers(50_000_000, 2_000_000_000),
    st.integers(2_000_000_000, 20_000_000_000),
)
_steps_ns = st.integers(50_000_000, 3_600_000_000_000).flatmap(lambda n: st.sampled_from([n, -n]))
_held_ns = st.sampled_from([0, 0, 0, 500, 10_000_000])

made_reads: st.SearchStrategy[list[MadeRead]] = st.lists(
    st.builds(
        MadeRead,
        _pauses_ns,
        st.booleans(),
        st.sampled_from([0, 1, 1, 1, 1, 2, 3, 7, 40, 300]),
        st.booleans(),
        st.one_of(*[st.just(0)] * 4, _steps_ns),
        st.tuples(_held_ns, _held_ns),
    ),
    max_size=40,
)


# What a telnet server may send beside data: commands, options, subnegotiations of RFC 2217.
telnet_commands = (
    st.sampled_from([b"\xff\xf1", b"\xff\xf9", b"\xff\xf6"])
    | st.tuples(st.integers(251, 254), st.integers(0, 60).filter(lambda option: option != 44)).map(
        lambda command: bytes((255, *command))
    )
    | st.binary(max_size=12).map(
        lambda content: b"\xff\xfa" + content.replace(b"\xff", b"\xff\xff") + b"\xff\xf0"
    )
)

# What YAML may take for a truth or a number, and what looks like one.
yaml_scalars = (
    st.sampled_from([*"yYnN", "yes", "No", "NO", "off", "Off", "On", "TRUE", "true", "False"])
    | st.sampled_from(["null", "~", ".nan", ".NaN", ".inf", "-.INF", "nan", "inf", "-Infinity"])
    | st.from_regex(r"[-+]?0?[xXob]?[0-9a-f]{1,6}", fullmatch=True)
    | st.from_regex(r"[-+]?[0-9]{0,3}\.?[0-9]{0,3}([eEp][-+]?[0-9]{1,4})?", fullmatch=True)
    | st.integers().map(str)
    | st.floats().map(repr)
).filter(bool)

node_names = st.text("abZ09_-/~.ä ", max_size=8)

# Files of the launcher: names, and values that may stand where something else should.
program_names = st.text("ABCdef_123é", min_size=1, max_size=8)
_launcher_keys = st.sampled_from(
    [
        *("sessions", "env", "nodes", "session_name", "workspace_root", "ros_setup", "conda_env"),
        *("name", "project", "command", "cpus", "autostart", "restart", "required", "after"),
        *("after_timeout_s", "parameters", "backend", "pty", "policy", "limit", "log", "backoff_s"),
    ]
)
_launcher_scalars = (
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | program_names
)
launcher_data = st.dictionaries(
    _launcher_keys,
    st.recursive(
        _launcher_scalars | st.sampled_from(["on-failure", "0-3", "exit 0", "log: (", "started"]),
        lambda inner: (
            st.lists(inner, max_size=3) | st.dictionaries(_launcher_keys, inner, max_size=6)
        ),
        max_leaves=25,
    ),
    max_size=4,
)


@st.composite
def waiting_programs(draw: st.DrawFn) -> dict[str, list[str]]:
    """Programs with the ones that each waits for, without a circle, in any order."""
    names = draw(st.lists(program_names, unique=True, min_size=1, max_size=8))
    after = {
        name: draw(st.lists(st.sampled_from(names[:n]), unique=True)) if n else []
        for n, name in enumerate(names)
    }
    return {name: after[name] for name in draw(st.permutations(names))}


# All that has a meaning somewhere in YAML, and words that are no texts without quotes.
YAML_TEXTS = st.text(
    st.sampled_from("ab -:#,[]{}'\"\n01.+eE?!&*%@`|>~=yYoOnN_xé\\/<\xa0"), max_size=6
)
_YAML_WORDS = st.sampled_from(
    ["yes", "Off", "null", "0x1F", "1e5", "1.5e+3", ".inf", "2026-01-02", "1:2"]
)
_YAML_SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | YAML_TEXTS | _YAML_WORDS
YAML_KEYS = st.from_regex(r"\A[a-z]\w{0,5}(\.[a-z]\w*)?\Z")
YAML_DATA = st.recursive(
    _YAML_SCALARS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(YAML_KEYS, inner, max_size=3),
    max_leaves=8,
)
