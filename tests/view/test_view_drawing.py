"""Text and pictures in cells: they have the size that was asked for, whatever is drawn."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase_view.drawing.attitude import board
from rosbase_view.drawing.bars import Scale, filled, signed
from rosbase_view.drawing.canvas import Canvas
from rosbase_view.drawing.figures import age, duration, number, rate, size
from rosbase_view.drawing.glyphs import ASCII, UNICODE, Glyphs
from rosbase_view.drawing.lines import Ink, Span, cells, clipped, fitted, line, plain
from rosbase_view.drawing.sparkline import Sparkline
from rosbase_view.drawing.table import Cell, Column, row_line, widths

WIDTHS = st.integers(0, 200)
TEXTS = st.text(max_size=50)
GLYPHS = st.sampled_from([UNICODE, ASCII])
both_glyphs = pytest.mark.parametrize("glyphs", [UNICODE, ASCII], ids=["unicode", "ascii"])


@given(TEXTS, WIDTHS)
def test_text_from_outside_is_one_harmless_line_that_fits(text: str, width: int) -> None:
    shown = clipped(text, width)
    assert shown.isprintable()
    assert cells(shown) <= width


@given(st.lists(st.text("ab 日本é", max_size=9), max_size=5), WIDTHS)
def test_a_fitted_line_has_exactly_its_width(texts: list[str], width: int) -> None:
    made = fitted(line(*(Span(text, Ink.DIM) for text in texts)), width)
    assert cells(plain(made)) == width


def test_text_that_is_cut_says_so() -> None:
    assert clipped("quadruped", 5) == "quad~"
    assert clipped("quad", 5) == "quad"


def test_an_escape_sequence_in_a_name_is_shown_and_not_obeyed() -> None:
    assert clipped("a\x1b[2J", 20) == r"a\x1b[2J"


@given(st.lists(st.floats(0.0, 1e9), max_size=100), st.integers(0, 40), GLYPHS)
def test_a_sparkline_has_its_width(values: list[float], width: int, glyphs: Glyphs) -> None:
    sparkline = Sparkline()
    for value in values:
        sparkline.add(value)
    assert len(sparkline.draw(width, glyphs)) == width


def test_the_largest_value_fills_its_cell_and_a_small_one_is_not_nothing() -> None:
    sparkline = Sparkline()
    for value in (0.0, 0.001, 50.0, 100.0):
        sparkline.add(value)
    assert sparkline.draw(5, UNICODE) == "  ▁▄▇"
    assert sparkline.draw(2, UNICODE) == "▄▇"


@given(st.floats(), st.floats(1e-3, 1e3), st.integers(0, 80), GLYPHS)
def test_a_bar_has_the_same_width_for_every_number(
    value: float, most: float, width: int, glyphs: Glyphs
) -> None:
    assert len(signed(value, most, width, glyphs)) == 2 * (max(0, width - 1) // 2) + 1
    assert len(filled(value if math.isfinite(value) else 0.0, width, glyphs)) == width


def test_bars_grow_from_the_middle() -> None:
    assert signed(1.0, 2.0, 9, ASCII) == "    |##  "
    assert signed(-2.0, 2.0, 9, ASCII) == "####|    "


def test_a_scale_grows_in_steps_and_never_shrinks() -> None:
    scale = Scale(2.0)
    scale.include(-3.0, math.inf, math.nan)
    assert scale.most == 5.0
    scale.include(0.1)
    assert scale.most == 5.0
    scale.include(10.0)
    assert scale.most == 10.0


@given(WIDTHS)
def test_columns_never_take_more_than_the_pane(width: int) -> None:
    columns = (Column("A", 10, share=1), Column("B", 5, is_right=True), Column("C", 8, share=2))
    sizes = widths(columns, width)
    made = row_line([Cell("x" * 300)] * 3, columns, sizes, margin="")
    assert cells(plain(made)) <= width
    # All of the room is used if all columns fit.
    if width >= 27:
        assert cells(plain(made)) == width


def test_numbers_have_room_for_their_sign() -> None:
    assert [number(9.80665), number(-0.5), number(3)] == [" 9.80665", "-0.5", " 3"]
    assert number(math.nan) == " nan"


@pytest.mark.parametrize(
    ("time_ns", "text"),
    [(None, "-"), (0, "now"), (999_999_999, "now"), (3_240_000_000, "3.2 s"),
     (59_900_000_000, "59 s"), (720_000_000_000, "12 m"), (10_000_000_000_000, "2 h"),
     (10**15, "11 d")],
)  # fmt: skip
def test_an_age_is_short(time_ns: int | None, text: str) -> None:
    assert age(time_ns) == text


def test_rates_sizes_and_durations_are_short() -> None:
    assert [rate(None), rate(199.84), rate(999.96), rate(10_000.0)] == [
        "-", "199.8 Hz", "1.0 kHz", "10.0 kHz",
    ]  # fmt: skip
    assert [size(None), size(999), size(29_100_000), size(3 * 10**12)] == [
        "-", "999 B", "29.1 MB", "3000.0 GB",
    ]  # fmt: skip
    assert [duration(5 * 10**9), duration(83 * 10**9), duration(10**14)] == [
        "5 s", "1:23", "1 d 03:46",
    ]  # fmt: skip


def test_a_cell_shows_eight_dots() -> None:
    canvas = Canvas(1, 1, UNICODE)
    canvas.line((0, 0), (0, 3))
    canvas.line((1, 0), (1, 3))
    assert canvas.text() == ["⣿"]


def test_what_lies_outside_of_a_canvas_is_left_out() -> None:
    canvas = Canvas(3, 2, ASCII)
    canvas.line((-5, 0), (9, 0))
    assert canvas.text() == ["***", "   "]


@given(
    st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: max(map(abs, q)) > 1e-3),
    st.integers(8, 80),
    st.integers(4, 30),
    GLYPHS,
)
def test_a_board_of_any_orientation_fits(
    quaternion: tuple[float, float, float, float], columns: int, rows: int, glyphs: Glyphs
) -> None:
    picture = [plain(row) for row in board(quaternion, columns, rows, glyphs)]
    assert [len(row) for row in picture] == [columns] * rows
    assert any(row.strip() for row in picture)


@both_glyphs
def test_a_board_that_is_turned_looks_different(glyphs: Glyphs) -> None:
    level = board((0.0, 0.0, 0.0, 1.0), 40, 12, glyphs)
    half = math.sqrt(0.5)
    rolled = board((half, 0.0, 0.0, half), 40, 12, glyphs)
    assert level != rolled
    # The same rotation has two quaternions.
    assert level == board((0.0, 0.0, 0.0, -1.0), 40, 12, glyphs)
    assert rolled == board((2 * half, 0.0, 0.0, 2 * half), 40, 12, glyphs)


def test_a_nose_up_is_drawn_higher() -> None:
    def middle(quaternion: tuple[float, float, float, float]) -> float:
        """Height of the right half of the picture, where the nose is."""
        rows = [plain(row) for row in board(quaternion, 40, 16, ASCII)]
        marked = [y for y, row in enumerate(rows) for x in range(26, 40) if row[x] == "*"]
        return sum(marked) / len(marked)

    # A turn about the axis to the left lowers the nose (REP-103).
    down = math.sin(math.radians(20.0) / 2.0), math.cos(math.radians(20.0) / 2.0)
    assert middle((0.0, -down[0], 0.0, down[1])) < middle((0.0, down[0], 0.0, down[1]))


def test_no_rotation_is_an_error() -> None:
    with pytest.raises(ValueError, match="no rotation"):
        board((0.0, 0.0, 0.0, 0.0), 20, 10, ASCII)
