"""Times and durations can be computed with and compared, as those of rclpy."""

import pickle
import sys
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.messages import Duration, Header, Time

S = 1_000_000_000
nanoseconds = st.integers(-(2**31) * S, 2**31 * S - 1)
raw = st.tuples(st.integers(-(2**31), 2**31 - 1), st.integers(0, 2**32 - 1))


class Foreign:
    """As those of rclpy: a class of the same name, which has its nanoseconds."""

    def __init__(self, count: int) -> None:
        self.nanoseconds = count


RclpyTime, RclpyDuration = type("Time", (Foreign,), {}), type("Duration", (Foreign,), {})


class Fields:
    """As the messages of ROS."""

    def __init__(self, count: int) -> None:
        self.sec, self.nanosec = divmod(count, S)


RosTime, RosDuration = type("Time", (Fields,), {}), type("Duration", (Fields,), {})
TIMES: list[Any] = [Time.from_nanoseconds, RclpyTime, RosTime]
DURATIONS: list[Any] = [Duration.from_nanoseconds, RclpyDuration, RosDuration]


@given(nanoseconds, nanoseconds, st.sampled_from(TIMES), st.sampled_from(DURATIONS))
def test_sums_and_differences_are_exact_with_the_objects_of_rclpy_on_either_side(
    a: int, b: int, make_time: Any, make_duration: Any
) -> None:
    time, duration = Time.from_nanoseconds(a), Duration.from_nanoseconds(a)
    cases: list[tuple[Any, type[Time | Duration], int]] = [
        (time + make_duration(b), Time, a + b),
        (make_duration(b) + time, Time, a + b),
        (time - make_duration(b), Time, a - b),
        (time - make_time(b), Duration, a - b),
        (make_time(b) - time, Duration, b - a),
        (make_time(b) + duration, Time, b + a),
        (duration + make_time(b), Time, a + b),
        (make_time(b) - duration, Time, b - a),
        (duration + make_duration(b), Duration, a + b),
        (make_duration(b) + duration, Duration, a + b),
        (duration - make_duration(b), Duration, a - b),
        (make_duration(b) - duration, Duration, b - a),
        (-duration, Duration, -a),
    ]
    for got, kind, count in cases:
        assert type(got) is kind
        assert got.nanoseconds == count
        assert 0 <= got.nanosec < S


@given(raw, raw)
def test_comparison_goes_by_nanoseconds_and_equal_ones_have_equal_hashes(
    a: tuple[int, int], b: tuple[int, int]
) -> None:
    kinds: list[tuple[Any, Any]] = [(Time, RclpyTime), (Duration, RclpyDuration)]
    for kind, foreign in kinds:
        one, two = kind(*a), kind(*b)
        for other in (two, foreign(two.nanoseconds)):
            assert (one < other) is (one.nanoseconds < two.nanoseconds)
            assert (one <= other) is (one.nanoseconds <= two.nanoseconds)
            assert (one > other) is (one.nanoseconds > two.nanoseconds)
            assert (one >= other) is (one.nanoseconds >= two.nanoseconds)
            assert (one == other) is (one.nanoseconds == two.nanoseconds)
        same = kind.from_nanoseconds(one.nanoseconds)
        assert same == one
        assert hash(same) == hash(one)
        assert (same == foreign(one.nanoseconds)) is True


def test_what_makes_no_sense_is_refused_by_python() -> None:
    time: Any = Time(1)
    duration: Any = Duration(1)
    for wrong in (
        lambda: time + Time(1),
        lambda: time + 1,
        lambda: 1 + time,
        lambda: 1 - time,
        lambda: duration + 1.0,
        lambda: 1.0 + duration,
        lambda: 1 - duration,
        lambda: duration - time,
        lambda: time < duration,
        lambda: time >= 1,
        lambda: duration > None,
        lambda: duration <= "1",
        lambda: RosDuration(1) - time,
        lambda: sum([time]),
    ):
        with pytest.raises(TypeError):
            wrong()  # type: ignore[no-untyped-call]  # lambdas have no types
    assert time != duration
    assert time != 1_000_000_000
    assert time != Header(time)
    assert (time == None) is False  # noqa: E711 - the operator is the test


def test_they_are_sorted_used_as_keys_pickled_and_cannot_be_changed() -> None:
    times = [Time(2), Time(1, 5), Time(1)]
    assert sorted(times) == [Time(1), Time(1, 5), Time(2)]
    assert max(times) - min(times) == Duration(1)
    assert {Time(1): "a"}[Time(0, S)] == "a"
    assert pickle.loads(pickle.dumps(Time(1, 2))) == Time(1, 2)
    with pytest.raises(AttributeError):
        times[0].sec = 1  # type: ignore[misc]  # the mistake is the test
    assert repr(Time(1, 2)) == "Time(sec=1, nanosec=2)"
    assert repr(-Duration(0, 1)) == "Duration(sec=-1, nanosec=999999999)"
    assert Time(1).to_msg() is not None
    assert Duration(3).to_msg() == Duration(3)


@given(raw, raw)
def test_the_numbers_of_numpy_never_overflow(a: tuple[int, int], b: tuple[int, int]) -> None:
    kinds: list[Any] = [Time, Duration]
    for kind in kinds:
        own, other = kind(*a), kind(*b)
        theirs = kind(np.int32(a[0]), np.uint32(a[1]))
        wide = kind(np.int64(a[0]), np.int64(a[1]))
        for same in (theirs, wide):
            assert type(same.nanoseconds) is int
            assert same.nanoseconds == own.nanoseconds
            assert same == own
            assert hash(same) == hash(own)
            assert other - same == other - own
            assert same - other == own - other
            assert (same < other) == (own < other)
            assert (same.to_msg().sec, same.to_msg().nanosec) == a


def test_fractions_of_a_second_are_refused_when_they_are_computed_with() -> None:
    kinds: list[Any] = [Time, Duration]
    for kind in kinds:
        for compute in (lambda wrong: wrong.nanoseconds, hash, lambda wrong: wrong + Duration(1)):
            with pytest.raises(TypeError):
                compute(kind(1.5))


def test_to_msg_returns_the_object_itself_until_the_program_has_loaded_messages_of_ros(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delitem(sys.modules, "builtin_interfaces.msg", raising=False)
    for own in (Time(1, 2), Duration(1, 2)):
        assert own.to_msg() is own

    def make(name: str) -> Any:
        return lambda **fields: (name, fields)

    ros = SimpleNamespace(Time=make("Time"), Duration=make("Duration"))
    monkeypatch.setitem(sys.modules, "builtin_interfaces.msg", ros)
    assert Time(1, 2).to_msg() == ("Time", {"sec": 1, "nanosec": 2})
    assert (Time(3) - Time(1)).to_msg() == ("Duration", {"sec": 2, "nanosec": 0})
    # While another thread imports them.
    monkeypatch.setitem(sys.modules, "builtin_interfaces.msg", SimpleNamespace())
    assert Time(1, 2).to_msg() == Time(1, 2)
