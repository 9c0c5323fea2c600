"""Output of children as lines: bounded, whatever comes."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.processes.output import OutputLines
from rosbase.processes.restart import RestartPolicy, Restarts
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
    assert all(len(line) <= 4 * 10 + len(" ... 300 more bytes") for line in lines)


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
        [r"\x1b[2K\r[INFO] [manager]: well"],
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
