"""The panel of a run: lines of whole fields that fit the terminal, whatever the numbers."""

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.cli.panel.bars import Scale, bar
from rosbase.cli.panel.drawing import LEAST_WIDTH, Panel, View
from rosbase.cli.panel.fields import Field, row, sentence, wrapped
from rosbase.cli.panel.style import Style, style_of
from rosbase.messages import Imu, MagneticField, Quaternion, Vector3

PLAIN = Style()
WIDTHS = st.integers(LEAST_WIDTH - 1, 200)
NUMBERS = st.floats(-1e9, 1e9)
VECTORS = st.builds(Vector3, NUMBERS, NUMBERS, NUMBERS)
ABSENT = (-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
COLOURS = re.compile(r"\x1b\[[\d;]+m")


def seen(line: str) -> str:
    return COLOURS.sub("", line)


def view(sample: Imu | MagneticField | None, note: str = "OK: samples arrive") -> View:
    counts = [Field("rate", "100.0 Hz"), Field("published", "123"), Field("received", "123")]
    return View([Field("rosbase imu"), Field("", "3.2 s")], counts, sample, note, ("green",))


@given(WIDTHS, VECTORS, VECTORS, st.booleans(), st.booleans())
def test_no_line_is_wider_than_the_terminal_and_no_number_is_cut(
    width: int, force: Vector3, rate: Vector3, has_colour: bool, has_unicode: bool
) -> None:
    panel = Panel(Style(has_colour, has_unicode))
    sample = Imu(
        orientation=Quaternion(0.0, 0.0, 0.0, 1.0), linear_acceleration=force, angular_velocity=rate
    )
    lines = [seen(line) for line in panel.draw(view(sample), width)]
    assert len(lines) == 8
    assert max(map(len, lines)) <= width
    for axis, line in zip("xyz", lines[4:7], strict=True):
        name, first, *_ = line.split()
        assert name == axis
        assert float(first) == pytest.approx(getattr(force, axis), rel=0.06, abs=0.006)
        numbers = re.findall(r"[+-]\d+(?:\.\d+)?(?:e[+-]\d+)?", line)
        assert float(numbers[1]) == pytest.approx(getattr(rate, axis), rel=0.06, abs=0.006)


@given(WIDTHS, st.text(alphabet=st.characters(categories=["L", "Nd", "Zs"]), max_size=300))
def test_a_note_is_cut_between_words(width: int, note: str) -> None:
    (*_, line) = Panel(PLAIN).draw(view(None, note), width)
    assert len(line) <= width
    assert set(line.split()) <= {*note.split(), "..."}
    if len(" ".join(note.split())) <= width:
        assert line == " ".join(note.split())


def test_without_a_sample_or_an_orientation_there_is_no_attitude() -> None:
    panel = Panel(PLAIN)
    assert panel.draw(view(None), 80)[2:] == ["OK: samples arrive"]
    raw = Imu(orientation_covariance=ABSENT)
    assert panel.draw(view(raw), 80)[2] == "orientation not measured"
    lines = Panel(PLAIN).draw(view(Imu(angular_velocity_covariance=ABSENT)), 80)
    assert [line.split()[2:] for line in lines[4:7]] == [["|", "not", "measured"]] * 3
    field = MagneticField(magnetic_field=Vector3(2.1e-5, -4e-6, 4.35e-5))
    assert panel.draw(view(field), 80)[2] == (
        "magnetic field   x   +21.00 uT   y    -4.00 uT   z   +43.50 uT"
    )


@given(st.lists(st.builds(Field, st.text("ab", min_size=1), st.text("12"))), st.integers(0, 80))
def test_a_row_has_as_many_whole_fields_as_fit(fields: list[Field], width: int) -> None:
    shown = row(fields, width, PLAIN)
    assert len(shown) <= width
    texts = [" ".join(part for part in (field.name, field.value) if part) for field in fields]
    rows = ["   ".join(texts[:number]) for number in range(len(texts) + 1)]
    assert shown == max((text for text in rows if len(text) <= width), key=len)


@given(NUMBERS, st.sampled_from([1.0, 20.0, 5e9]), st.integers(1, 60).map(lambda n: 2 * n + 1))
def test_a_bar_grows_from_the_middle_to_the_side_of_its_sign(
    value: float, most: float, width: int
) -> None:
    drawn = bar(value, most, width, PLAIN)
    left, middle, right = drawn[: width // 2], drawn[width // 2], drawn[width // 2 + 1 :]
    assert (len(drawn), middle) == (width, "|")
    assert not (left if value >= 0 else right).strip()
    length = drawn.count("#")
    assert abs(length - min(1.0, abs(value) / most) * (width // 2)) <= 1
    assert (right if value >= 0 else left[::-1]).rstrip() == "#" * length


@given(st.lists(st.floats(0.0, 1e12), min_size=1))
def test_a_scale_grows_to_a_round_number_and_never_shrinks(values: list[float]) -> None:
    scale = Scale(2.0)
    largest = 0.0
    for value in values:
        before = scale.most
        scale.include(-value)
        largest = max(largest, value)
        assert scale.most >= max(before, largest)
        assert scale.most <= max(2.0, 2.5001 * largest)
        assert float(f"{scale.most:e}"[:1]) in (1, 2, 5) or math.isclose(scale.most, 1.0)


def test_colours_are_left_out_where_they_are_not_wanted() -> None:
    assert style_of("UTF-8", {"TERM": "xterm"}) == Style(has_colour=True, has_unicode=True)
    assert style_of("UTF-8", {"TERM": "xterm", "NO_COLOR": ""}).has_colour
    assert not style_of("utf-8", {"TERM": "xterm", "NO_COLOR": "1"}).has_colour
    assert not style_of("utf8", {"TERM": "dumb"}).has_colour
    assert style_of("ANSI_X3.4-1968", {"TERM": "xterm"}) == Style(has_colour=True)
    assert style_of(None, {}) == Style()


def test_long_lines_break_between_words_and_paths_stay_whole() -> None:
    text = "[INFO] [reader]: /dev/serial/by-id/usb-a-very-long-name-of-a-port is not there"
    assert wrapped(text, 40).split("\n") == [
        "[INFO] [reader]:",
        "    /dev/serial/by-id/usb-a-very-long-name-of-a-port",
        "    is not there",
    ]
    assert sentence("a b " * 30, 20) == "a b a b a b a b ..."
