"""Messages that are written in one call: numbers, and one text of any length."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.messages import Header, Imu, String, Temperature
from rosbase.wire import serialize
from support.plain_cdr import PlainCdr

# Around those at which padding, or the way of writing, changes.
LENGTHS = [0, 1, 2, 3, 4, 5, 7, 8, 254, 255, 256, 257, 3000]
ZEROS = (0.0,) * 9


@given(st.lists(st.sampled_from(LENGTHS) | st.integers(0, 300), min_size=1, max_size=10))
def test_the_text_may_have_another_length_in_each_message(lengths: list[int]) -> None:
    for length in lengths:
        text = "é" * (length // 2) + "x" * (length % 2)
        for message in (
            Imu(Header(frame_id=text)),
            String(text),
            Temperature(Header(frame_id=text), 1.0, 2.0),
        ):
            data = serialize(message)
            plain = PlainCdr(message)
            assert plain.without_padding(data) == plain.data()


@pytest.mark.parametrize("wrong", ["a\0b", "\ud800", None, b"imu_link", 1])
def test_a_wrong_text_is_refused_and_the_next_one_is_written(wrong: object) -> None:
    before = serialize(Imu(Header(frame_id="imu_link")))
    with pytest.raises((TypeError, ValueError), match=r"Imu\.header\.frame_id"):
        serialize(Imu(Header(frame_id=wrong)))  # type: ignore[arg-type]  # as said
    assert serialize(Imu(Header(frame_id="imu_link"))) == before


@pytest.mark.parametrize("wrong", ["1.0", None, (1.0, 2.0)])
def test_a_wrong_number_is_refused_and_the_next_one_is_written(wrong: object) -> None:
    before = serialize(Temperature(Header(), 1.0, 2.0))
    with pytest.raises(TypeError, match=r"Temperature\.temperature"):
        serialize(Temperature(Header(), wrong, 2.0))  # type: ignore[arg-type]  # as said
    assert serialize(Temperature(Header(), 1.0, 2.0)) == before
