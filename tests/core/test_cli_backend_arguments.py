"""Arguments that are not the command's own, but the backend's."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.cli.backend_arguments import check_taken, split_arguments
from rosbase.contracts.backend import Backend, BackendOptions
from rosbase.errors import ConfigurationError
from rosbase.plugins import BackendPlugin


def never(options: BackendOptions) -> Backend:
    raise AssertionError


BACKENDS = {
    "plain": BackendPlugin("plain", "has none of its own", never),
    "far": BackendPlugin("far", "has some", never, arguments_after="--far-args"),
}
WORDS = st.lists(st.sampled_from(["-p", "a:=b", "--far-args", "--", ""]))


def test_what_follows_the_word_of_a_backend_is_not_for_the_command() -> None:
    words = ["imu", "-p", "a:=b", "--far-args", "-p", "c:=d"]
    own, found, theirs = split_arguments(words, BACKENDS)
    assert own == ["imu", "-p", "a:=b"]
    assert found == {"--far-args": "far"}
    assert theirs == ["--far-args", "-p", "c:=d"]


def test_two_dashes_end_it() -> None:
    words = ["imu", "--far-args", "-p", "c:=d", "--", "--duration", "1"]
    own, _, theirs = split_arguments(words, BACKENDS)
    assert own == ["imu", "--duration", "1"]
    assert theirs == ["--far-args", "-p", "c:=d", "--"]


@given(WORDS)
def test_what_is_left_is_in_order_and_without_the_word(words: list[str]) -> None:
    own, found, theirs = split_arguments(words, BACKENDS)
    rest, others = iter(words), iter(words)
    assert all(word in rest for word in own)
    assert all(word in others for word in theirs)
    assert len(own) + len(theirs) == len(words)
    assert "--far-args" not in own
    assert bool(found) is ("--far-args" in words)
    if not found:
        assert own == words


def test_arguments_of_another_backend_than_the_chosen_one_are_an_error() -> None:
    check_taken({"--far-args": "far"}, "far")
    with pytest.raises(ConfigurationError, match="--far-args are for the backend far, but this is"):
        check_taken({"--far-args": "far"}, "plain")
