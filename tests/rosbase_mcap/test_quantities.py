"""Sizes, spans and dates as users type them."""

import argparse

import pytest

from rosbase_mcap.quantities import moment_ns, moments_ns, size_bytes, span_ns

S = 1_000_000_000


@pytest.mark.parametrize(
    ("text", "size"), [("7", 7), ("500MB", 500_000_000), ("1.5 GB", 1_500_000_000), ("2k", 2000)]
)
def test_a_size_has_a_unit_or_is_in_bytes(text: str, size: int) -> None:
    assert size_bytes(text) == size


@pytest.mark.parametrize(
    ("text", "span"), [("60s", 60 * S), ("0.5", S // 2), ("10min", 600 * S), ("2h", 7200 * S)]
)
def test_a_span_has_a_unit_or_is_in_seconds(text: str, span: int) -> None:
    assert span_ns(text) == span


@pytest.mark.parametrize("text", ["", "-1s", "soon", "1 week", "nan", "1e999"])
def test_anything_else_is_a_usage_error(text: str) -> None:
    for read in (size_bytes, span_ns):
        with pytest.raises(argparse.ArgumentTypeError, match="is not a"):
            read(text)


def test_a_moment_is_a_date_or_a_span_from_the_start() -> None:
    assert moment_ns("1.5s", 7 * S) == 8_500_000_000
    assert moment_ns("1970-01-01T00:00:02.000001", 0) == 2_000_001_000
    assert moment_ns("1970-01-01T01:00:02+01:00", 0) == 2 * S
    assert moment_ns("1970-01-01T00:00:02Z", 0) == 2 * S
    with pytest.raises(argparse.ArgumentTypeError, match="no date"):
        moment_ns("2026-13-01", 0)


@pytest.mark.parametrize(
    ("start", "end", "reason"),
    [
        ("5s", "1s", "--from 5s is after --to 1s"),
        (None, "1970-01-01T00:00:06", "is before the start of the recording"),
        ("-1s", None, "'-1s' is not a time span"),
    ],
)
def test_moments_with_nothing_between_them_are_refused(
    start: str | None, end: str | None, reason: str
) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match=reason):
        moments_ns(start, end, 7 * S)
    assert moments_ns("1970-01-01T00:00:06", "1s", 7 * S) == (6 * S, 8 * S)
