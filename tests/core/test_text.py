"""Text from outside: one line of what can be seen, and no more of it than is sane."""

import logging
from unicodedata import bidirectional, category

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.launcher.display.cells import cut, padded, width
from rosbase.text.printable import MOST_LINE, MOST_QUOTED, indented, log_line, one_line, printable
from support.strategies import outside_texts

ENDS = "\n\r\v\f\x1c\x1d\x1e\x85\u2028\u2029"
TURNS = {"LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI"}


def harmless(text: str) -> bool:
    return not any(
        character in ENDS
        or category(character) in ("Cc", "Cf", "Cs", "Zl", "Zp")
        or bidirectional(character) in TURNS
        for character in text
    )


@given(outside_texts | st.text(), st.integers(0, 300))
def test_of_any_text_comes_one_line_that_harms_nobody_and_is_not_too_long(
    text: str, most: int
) -> None:
    shown = printable(text, most)
    assert len(shown) <= most
    assert shown.isprintable()
    assert harmless(shown)
    # What can be sent and written anywhere.
    shown.encode()


@given(st.text(st.characters(codec="utf-8").filter(str.isprintable)))
def test_plain_text_stays_as_it_is(text: str) -> None:
    assert printable(text, len(text)) == text
    assert printable(text) == (
        text if len(text) <= MOST_QUOTED else text[: MOST_QUOTED - 3] + "..."
    )


@given(outside_texts, st.integers(0, 300))
def test_what_has_been_made_printable_is_not_changed_again(text: str, most: int) -> None:
    once = printable(text, most)
    assert printable(once, most) == once


SHOWN = {
    "lab/\x1b[2J": r"lab/\x1b[2J",
    "lab/\u202eumi": r"lab/\u202eumi",
    "a\nb\r\n": r"a\nb\r\n",
    "a\x85\u2028\u2029": r"a\x85\u2028\u2029",
    "a\u200e\u200f\u061c\u2066\u2069": r"a\u200e\u200f\u061c\u2066\u2069",
    "\0\x07\x7f\x9b": r"\x00\x07\x7f\x9b",
    "\udcff\U000e0041": r"\udcff\U000e0041",
    "5 °C, 雪 and C:\\new": "5 °C, 雪 and C:\\new",
    "": "",
}


@pytest.mark.parametrize(("text", "shown"), SHOWN.items(), ids=SHOWN.values())
def test_what_cannot_be_seen_is_an_escape(text: str, shown: str) -> None:
    assert printable(text) == shown


def test_a_cut_never_leaves_half_an_escape() -> None:
    for most in range(3, 30):
        shown = printable("ab\u202ecd\x1befgh" * 3, most)
        assert shown.endswith("...")
        assert "ab\\u202ecd\\x1befgh".startswith(shown[:-3][:16])
        assert shown[:-3].count("\\") == sum(shown.count(escape) for escape in ("\\u202e", "\\x1b"))


def test_a_huge_text_costs_no_time() -> None:
    assert printable("\x1b" * 100_000_000, 8) == r"\x1b..."


@given(outside_texts)
def test_prose_keeps_its_words_on_one_line(text: str) -> None:
    assert harmless(one_line(text))
    assert one_line("a\n  b\tc") == "a b c"


@given(outside_texts)
def test_no_line_below_a_record_looks_like_a_record(text: str) -> None:
    for line in indented(text).split("\n"):
        assert not line or line.startswith("  ")
        assert harmless(line)


def test_of_a_long_traceback_both_ends_are_kept() -> None:
    lines = indented("\n".join(str(number) for number in range(10_000))).split("\n")
    assert (lines[0], lines[100], lines[-1]) == ("  0", "  ... 9800 more lines", "  9999")


def test_a_message_may_be_any_object_and_its_tabs_are_blanks() -> None:
    assert log_line(13) == "13"
    assert log_line("a\tb") == "a       b"
    assert len(log_line("x" * 1_000_000)) == MOST_LINE


@given(outside_texts)
def test_a_record_of_any_text_is_one_line_for_every_handler(text: str) -> None:
    from rosbase.logger import RosbaseLogger

    records: list[logging.LogRecord] = []

    class Keeps(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            records.append(record)

    keeps = Keeps()
    logging.getLogger("rosbase").addHandler(keeps)
    try:
        RosbaseLogger("text").warning(text)
        RosbaseLogger("text").error("broken", exc_info=ValueError(text))
    finally:
        logging.getLogger("rosbase").removeHandler(keeps)
    plain, broken = (logging.Formatter("%(message)s").format(record) for record in records)
    assert harmless(plain)
    first, *below = broken.split("\n")
    assert first == "broken"
    assert all(line.startswith("  ") and harmless(line) for line in below)


@pytest.mark.parametrize(
    ("text", "cells"), [("", 0), ("abc", 3), ("雪だるま", 8), ("e\u0301", 1), ("°±", 2), ("한", 2)]
)
def test_wide_characters_take_two_cells_and_accents_none(text: str, cells: int) -> None:
    assert width(text) == cells
    assert cut(text, cells) == text


@given(st.text(st.sampled_from("ab雪\u0301°한")), st.integers(0, 20))
def test_a_text_is_cut_and_padded_to_its_cells(text: str, cells: int) -> None:
    assert width(cut(text, cells)) <= cells
    assert width(padded(cut(text, cells), cells)) == cells
