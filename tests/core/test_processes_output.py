"""Output of children as lines: bounded, whatever comes."""

from itertools import zip_longest

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.processes.output import OutputLines
from rosbase.processes.restart import RestartPolicy, Restarts
from rosbase.processes.tracebacks import Tracebacks
from rosbase.testing.strategies import chunkings
from support.strategies import outside_texts

printables = st.characters(codec="utf-8").filter(str.isprintable)
texts = st.lists(st.text(printables, min_size=1))


def lines_of(output: OutputLines, chunks: list[bytes]) -> list[str]:
    lines = [line for chunk in chunks for line in output.feed(chunk, 0)]
    return lines + list(output.finish())


@given(st.data(), texts)
def test_lines_come_out_the_same_for_every_chunking(data: st.DataObject, wanted: list[str]) -> None:
    stream = "".join(f"{line}\n" for line in wanted).encode()
    assert lines_of(OutputLines(), data.draw(chunkings(stream))) == wanted


@given(st.data(), st.binary(max_size=300))
def test_whatever_comes_is_bounded(data: st.DataObject, stream: bytes) -> None:
    output = OutputLines(max_line_bytes=10, max_lines_per_s=5)
    lines = lines_of(output, data.draw(chunkings(stream)))
    assert len(lines) <= 5 + 2
    assert all(len(line) <= 8 * 10 + len(" ... 300 more bytes") for line in lines)


@given(st.lists(outside_texts, max_size=3))
def test_whatever_a_child_writes_each_line_is_one_of_printable_characters(words: list[str]) -> None:
    stream = "\n".join(words).encode(errors="surrogatepass")
    for line in lines_of(OutputLines(), [stream]):
        assert line.isprintable(), "nothing that clears a screen, sets a title or ends a line"


SHOWN = {
    "colours": (b"\x1b[1;31mhot\x1b[0m", ["hot"]),
    "colours as of today": (b"\x1b[38:2::255:0:0mhot\x1b[m", ["hot"]),
    "nothing but colours": (b"\x1b[0m", []),
    "a table": (b"a\tb", ["a       b"]),
    "a line over the last one": (
        b"\x1b[2K\r[INFO] [manager]: well",
        [r"\x1b[2K", "[INFO] [manager]: well"],
    ),
    "a title": (b"\x1b]0;mine\x07", [r"\x1b]0;mine\x07"]),
    "a screen": (b"\x1bc\x1b[2J", [r"\x1bc\x1b[2J"]),
    "as one byte": (b"\xc2\x9b2J", [r"\x9b2J"]),
    "another line": ("a\u2028b\x85c\x0bd".encode(), [r"a\u2028b\x85c\x0bd"]),
    "backwards": ("a\u202eb\u2066".encode(), [r"a\u202eb\u2066"]),
    "no text": (b"\xff\xfe", [r"\xff\xfe"]),
}


@pytest.mark.parametrize(("written", "shown"), SHOWN.values(), ids=SHOWN)
def test_what_could_forge_or_hide_a_line_is_shown_as_escapes(
    written: bytes, shown: list[str]
) -> None:
    assert lines_of(OutputLines(), [written + b"\n"]) == shown


@given(st.data(), st.integers(0, 60))
def test_no_line_goes_uncounted(data: st.DataObject, number: int) -> None:
    output = OutputLines(max_lines_per_s=20)
    lines = lines_of(output, data.draw(chunkings(b"x\n" * number)))
    shown = lines.count("x")
    assert shown == min(number, 20)
    assert lines[shown:] == ([f"... {number - 20} more lines"] if number > 20 else [])


@given(st.data(), texts, st.lists(st.sampled_from(["\n", "\r", "\r\n", "\n\n", "\r\r\n"])))
def test_a_line_ends_with_any_of_the_usual_ends(
    data: st.DataObject, wanted: list[str], ends: list[str]
) -> None:
    pairs = zip_longest(wanted, ends[: len(wanted)], fillvalue="\n")
    stream = "".join(line + end for line, end in pairs).encode()
    assert lines_of(OutputLines(), data.draw(chunkings(stream))) == wanted


def test_a_line_that_was_begun_is_given_after_a_second_and_not_before() -> None:
    output = OutputLines()
    assert output.due_ns is None
    assert list(output.feed(b"ready", 5)) == []
    assert output.due_ns == 1_000_000_005
    assert list(output.feed(b"? ", 900_000_000)) == []
    assert list(output.tick(1_000_000_004)) == []
    assert list(output.tick(1_000_000_005)) == ["ready? "]
    assert output.due_ns is None
    assert list(output.feed(b"yes\n", 1_500_000_000)) == ["yes"]


def test_a_count_of_lines_is_given_though_nothing_comes_any_more() -> None:
    output = OutputLines(max_lines_per_s=1)
    assert list(output.feed(b"a\nb\nc\n", 0)) == ["a"]
    assert output.due_ns == 1_000_000_000
    assert list(output.tick(999_999_999)) == []
    assert list(output.tick(1_000_000_000)) == ["... 2 more lines"]
    assert output.due_ns is None


def test_a_line_that_was_begun_waits_until_there_may_be_a_line_again() -> None:
    output = OutputLines(max_lines_per_s=1)
    assert list(output.feed(b"a\n", 0)) == ["a"]
    assert list(output.feed(b"b", 1)) == []
    assert output.due_ns == 1_000_000_001
    assert list(output.feed(b"\nc\nd", 500_000_000)) == []
    assert list(output.tick(1_000_000_000)) == ["... 2 more lines"]
    assert list(output.tick(1_500_000_000)) == ["d"]


@given(st.data(), st.integers(0, 3000))
def test_the_last_words_are_the_end_of_what_was_written(data: st.DataObject, number: int) -> None:
    stream = b"".join(b"line %d\n" % n for n in range(number)) + b"the end"
    output = OutputLines(max_lines_per_s=100)
    given_ = [
        line for chunk in data.draw(chunkings(stream)) for line in output.feed(chunk, 0)
    ] + list(output.finish(last_words=True))
    assert given_[-1] == "the end"
    counts = [line for line in given_ if line.startswith("...")]
    shown = [line for line in given_[:-1] if line not in counts]
    left_out = sum(int(count.split()[1]) for count in counts)
    assert len(shown) + left_out == number
    if left_out:
        gap = given_.index(counts[0])
        assert shown[gap:] == [f"line {n}" for n in range(gap + left_out, number)]


def test_what_was_left_out_before_a_silence_is_among_the_last_words() -> None:
    output = OutputLines(max_lines_per_s=1)
    assert list(output.feed(b"a\nValueError: x\n", 0)) == ["a"]
    assert list(output.tick(2_000_000_000)) == ["... 1 more lines"]
    assert list(output.finish(last_words=True)) == ["ValueError: x"]


def test_what_was_left_out_before_lines_that_were_shown_is_not() -> None:
    output = OutputLines(max_lines_per_s=1)
    assert list(output.feed(b"a\nb\n", 0)) == ["a"]
    assert list(output.feed(b"c\n", 2_000_000_000)) == ["... 1 more lines", "c"]
    assert list(output.finish(last_words=True)) == []


def test_what_is_for_a_screen_is_left_out_only_where_there_seems_to_be_one() -> None:
    written = b"\x1b[1;31mred\x1b[0m\x1b]0;title\x07!\n"
    assert list(OutputLines(for_a_screen=True).feed(written, 0)) == ["red!"]
    assert list(OutputLines().feed(written, 0)) == [r"red\x1b]0;title\x07!"]


LAUNCHED = """
[eye-1] Traceback (most recent call last):
[eye-1]   File "eye.py", line 3, in <module>
[eye-1]     int("x")
[eye-1] ValueError: invalid literal
"""
CHAINED = """
Traceback (most recent call last):
  File "a.py", line 1, in <module>
KeyError: 1
During handling of the above exception, another exception occurred:
Traceback (most recent call last):
  File "a.py", line 2, in <module>
ValueError: 2
"""
GROUP = """
  + Exception Group Traceback (most recent call last):
  |   File "a.py", line 1, in <module>
  | ExceptionGroup: two (2 sub-exceptions)
  +-+---------------- 1 ----------------
    | ValueError: 1
    +---------------- 2 ----------------
    | KeyError: 2
    +------------------------------------
"""
THREAD = """
Exception in thread Thread-1 (read):
Traceback (most recent call last):
  File "a.py", line 1, in read
OSError: gone
"""
SYNTAX = """
  File "a.py", line 1
    int(
       ^
SyntaxError: '(' was never closed
"""


@pytest.mark.parametrize("traceback", [LAUNCHED, CHAINED, GROUP, THREAD, SYNTAX])
def test_a_traceback_begins_with_its_heading_and_ends_with_its_exception(traceback: str) -> None:
    lines = traceback.strip("\n").splitlines()
    tracebacks = Tracebacks()
    assert not tracebacks.is_part("before")
    assert [tracebacks.is_part(line) for line in lines] == [True] * len(lines)
    assert [tracebacks.is_part(line) for line in ("after", "  after", "")] == [False] * 3


@given(st.lists(st.text(st.characters(codec="utf-8"))))
def test_what_is_no_traceback_is_none(lines: list[str]) -> None:
    tracebacks = Tracebacks()
    assert not any(tracebacks.is_part(line) for line in lines)


def test_a_new_second_has_new_lines_and_says_what_was_left_out() -> None:
    output = OutputLines(max_lines_per_s=2)
    assert list(output.feed(b"a\nb\nc\nd\n", 0)) == ["a", "b"]
    assert list(output.feed(b"e\n", 999_999_999)) == []
    assert list(output.feed(b"f\n", 1_000_000_000)) == ["... 3 more lines", "f"]


def test_a_long_line_is_cut_and_says_how_much_is_missing() -> None:
    output = OutputLines(max_line_bytes=4)
    assert list(output.feed(b"abcdef", 0)) == []
    assert list(output.feed(b"gh\nok\r\n", 0)) == ["abcd ... 4 more bytes", "ok"]


def test_who_has_run_for_long_enough_begins_a_new_row_of_restarts() -> None:
    restarts = Restarts(RestartPolicy("on-failure", limit=2, first_delay_s=1.0, stable_s=10.0))
    first = [restarts.after_end(failed=True, ran_s=0.1) for _ in range(3)]
    assert first[0] is not None
    assert first[1] is not None
    assert first[2] is None
    assert restarts.has_given_up
    again = restarts.after_end(failed=True, ran_s=11.0)
    assert again is not None
    assert 0.5 <= again <= 1.0
    assert restarts.after_end(failed=False, ran_s=0.1) is None
    assert not restarts.has_given_up
