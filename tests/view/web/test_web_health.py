"""The health of a board, from its diagnostics."""

from typing import Any

from rosbase.messages import DiagnosticArray, DiagnosticStatus, Header
from rosbase.wire import schema, serialize
from rosbase.wire.plain import decoder
from rosbase_view.web.health import DIAGNOSTICS, Health, Status

SECOND = 1_000_000_000


def told(*statuses: DiagnosticStatus) -> Any:
    """A message as a view reads it."""
    data = bytes(serialize(DiagnosticArray(Header(), statuses)))
    return decoder(DIAGNOSTICS, schema(DiagnosticArray))(data)


def test_the_newest_status_of_each_name_is_shown() -> None:
    health = Health()
    health.take(told(DiagnosticStatus(level=1, name="b", message="slow")), 0)
    health.take(told(DiagnosticStatus(level=2, name="a", message="away")), 0)
    health.take(told(DiagnosticStatus(level=0, name="b", message="fine")), 0)
    assert health.statuses(0) == [Status("ERROR", "a", "away"), Status("OK", "b", "fine")]


def test_a_status_that_is_not_told_again_is_stale() -> None:
    health = Health()
    health.take(told(DiagnosticStatus(level=0, name="b", message="fine")), 0)
    assert health.statuses(5 * SECOND)[0].level == "OK"
    assert health.statuses(6 * SECOND) == [Status("STALE", "b", "silent; before: fine")]
    assert health.statuses(None) == [Status("OK", "b", "fine")]


def test_levels_have_the_names_of_ros_and_an_unknown_one_is_an_error() -> None:
    health = Health()
    statuses = [DiagnosticStatus(level=level, name=str(level)) for level in (0, 1, 2, 3, 9)]
    health.take(told(*statuses), 0)
    assert [one.level for one in health.statuses(0)] == ["OK", "WARN", "ERROR", "STALE", "ERROR"]


def test_names_without_end_do_not_fill_the_page() -> None:
    health = Health()
    for number in range(100):
        health.take(told(DiagnosticStatus(name=f"n{number:03d}")), 0)
    assert [one.name for one in health.statuses(0)] == [
        f"n{number:03d}" for number in range(80, 100)
    ]
