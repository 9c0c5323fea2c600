"""The history and the low pass of `rosbase.utils`."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.messages import Vector3
from rosbase.utils import CircularBuffer, VectorLPFilter

LENGTHS = st.integers(1, 6)
VALUES = st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=40)


def model(values: list[float], length: int) -> list[float]:
    return [*[values[0]] * length, *values[1:]][-length:]


@given(VALUES, LENGTHS)
def test_the_buffer_has_the_last_values_and_the_first_one_fills_it(
    values: list[float], length: int
) -> None:
    numbers, arrays, lists = (CircularBuffer(length) for _ in range(3))
    for value in values:
        numbers.append(value)
        lists.append([value, 0.0])
        arrays.append(np.array([value, 0.0]))
    expected = model(values, length)
    assert numbers.buffer == tuple(expected)
    assert lists.buffer == tuple((value, 0.0) for value in expected)
    assert arrays.buffer.tolist() == [[value, 0.0] for value in expected]


@given(VALUES, LENGTHS)
def test_what_was_read_of_arrays_stays_as_it_was(values: list[float], length: int) -> None:
    buffer, seen = CircularBuffer(length), []
    for value in values:
        buffer.append(np.array([value]))
        seen.append((buffer.buffer, buffer.buffer.copy()))
    for view, copy in seen:
        assert np.array_equal(view, copy)


def test_the_array_is_read_only_and_no_copy() -> None:
    buffer = CircularBuffer(4)
    buffer.append(np.zeros(3))
    assert np.shares_memory(buffer.buffer, buffer.buffer)
    with pytest.raises(ValueError, match="read-only"):
        buffer.buffer[0] = 1.0


def test_to_append_copies_one_row_and_not_the_history() -> None:
    # At the end of the array, and only there, the rows that still count are copied.
    buffer = CircularBuffer(100)
    buffer.append(np.zeros(3))
    memory = buffer.buffer.base
    for number in range(100):
        buffer.append(np.full(3, number))
        assert buffer.buffer.base is memory
    buffer.append(np.ones(3))
    assert buffer.buffer.base is not memory


def test_a_buffer_keeps_nothing_that_its_owner_may_change() -> None:
    for value in (np.zeros(2), [0.0, 0.0]):
        buffer = CircularBuffer(2)
        buffer.append(value)
        value[0] = 9.0
        assert np.array_equal(buffer.buffer, np.zeros((2, 2)))


def test_a_reset_lets_the_next_value_fill_the_buffer_with_another_shape() -> None:
    buffer = CircularBuffer(2)
    assert buffer.buffer == ()
    buffer.append(np.zeros(2))
    buffer.reset()
    assert buffer.buffer == ()
    buffer.append(7)
    assert buffer.buffer == (7, 7)


def test_a_buffer_of_length_0_swallows() -> None:
    for value in (1.0, np.ones(3)):
        buffer = CircularBuffer(0)
        for _ in range(3):
            buffer.append(value)
        assert len(buffer.buffer) == 0
    assert buffer.buffer.shape == (0, 3)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (np.zeros(3), np.zeros(4)),
        (np.zeros(3), np.zeros((1, 3))),
        (np.zeros(3), 1.0),
        ([1.0, 2.0], [1.0]),
        ([1.0, 2.0], 1.0),
        (1.0, [1.0]),
        ([[1.0], [2.0]], [[1.0], [2.0, 3.0]]),
        ((1.0, 2.0), np.zeros(3)),
    ],
    ids=repr,
)
def test_another_shape_is_refused_and_changes_nothing(first: Any, second: Any) -> None:
    buffer = CircularBuffer(2)
    buffer.append(first)
    before = buffer.buffer
    with pytest.raises(ValueError, match="shape"):
        buffer.append(second)
    assert np.array_equal(buffer.buffer, before)


def test_arrays_and_lists_of_one_shape_may_be_mixed() -> None:
    buffer = CircularBuffer(2)
    buffer.append(np.zeros(2))
    buffer.append([1, 2])
    assert buffer.buffer.tolist() == [[0.0, 0.0], [1.0, 2.0]]
    buffer.reset()
    buffer.append([1, 2])
    buffer.append(np.zeros(2))
    assert buffer.buffer == ((1, 2), (0.0, 0.0))


def test_floats_are_not_cut_to_integers() -> None:
    buffer = CircularBuffer(2)
    buffer.append(np.zeros(2, int))
    with pytest.raises(TypeError, match="same_kind"):
        buffer.append(np.full(2, 0.5))


def test_a_length_is_a_whole_number_from_0_on() -> None:
    with pytest.raises(ValueError, match="0 or more"):
        CircularBuffer(-1)
    length: Any = 2.0
    with pytest.raises(TypeError):
        CircularBuffer(length)


def test_the_first_vector_passes_through_and_later_ones_are_smoothed() -> None:
    smooth = VectorLPFilter(0.01, 5.0)
    assert smooth.get_values() == (0.0, 0.0, 0.0)
    smooth.update([1.0, 2.0, 3.0])
    assert smooth.get_values() == (1.0, 2.0, 3.0)
    smooth.update((2.0, 2.0, 3.0))
    share = 1 - math.exp(-2 * math.pi * 5.0 * 0.01)
    assert smooth.get_values() == pytest.approx((1.0 + share, 2.0, 3.0))


@given(st.floats(0.1, 50.0), st.lists(st.floats(1e-4, 0.1), min_size=1, max_size=20))
def test_a_step_is_answered_exactly_whatever_the_periods(
    cutoff_hz: float, periods: list[float]
) -> None:
    smooth = VectorLPFilter(0.01, cutoff_hz, 1)
    smooth.update([0.0])
    for period in periods:
        smooth.update([1.0], period)
    expected = 1 - math.exp(-2 * math.pi * cutoff_hz * sum(periods))
    assert smooth.get_values()[0] == pytest.approx(expected, abs=1e-12)


@given(st.lists(st.tuples(*[st.floats(-1e3, 1e3)] * 3), min_size=1, max_size=10))
def test_arrays_messages_and_lists_are_filtered_alike(vectors: list[tuple[float, ...]]) -> None:
    with_arrays, with_messages, with_lists = (VectorLPFilter(0.01, 3.0) for _ in range(3))
    for vector in vectors:
        with_arrays.update(np.array(vector))
        with_messages.update(Vector3(*vector))
        with_lists.update(list(vector))
    assert isinstance(with_arrays.get_values(), np.ndarray)
    assert with_messages.get_values() == with_lists.get_values()
    assert np.allclose(with_arrays.get_values(), with_lists.get_values())
    with_lists.update(np.zeros(3))
    assert isinstance(with_lists.get_values(), np.ndarray)


def test_what_is_done_to_the_arrays_outside_does_not_change_the_filter() -> None:
    smooth, vector = VectorLPFilter(0.01, 3.0), np.ones(3)
    smooth.update(vector)
    vector[:] = smooth.get_values()[:] = 7.0
    smooth.get_values()[:] = 9.0
    assert smooth.get_values().tolist() == [1.0] * 3


@pytest.mark.parametrize(
    "vector",
    [[1.0, 2.0], 4 * [1.0], np.zeros(2), np.zeros((3, 1)), [1, 2, math.nan], np.full(3, math.inf)],
    ids=repr,
)
def test_a_wrong_vector_is_refused_and_changes_nothing(vector: Any) -> None:
    smooth = VectorLPFilter(0.01, 3.0)
    smooth.update([1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match=r"vectors of 3 numbers|finite"):
        smooth.update(vector)
    assert smooth.get_values() == (1.0, 2.0, 3.0)


def test_the_numbers_of_a_filter_are_positive() -> None:
    for arguments in ((0.0, 5.0), (0.01, -1.0), (0.01, math.inf), (math.nan, 5.0), (0.01, 5.0, 0)):
        with pytest.raises(ValueError, match=r"positive|1 or more"):
            VectorLPFilter(*arguments)
    with pytest.raises(ValueError, match="sample_period"):
        VectorLPFilter(0.01, 5.0, 1).update([1.0], 0.0)
