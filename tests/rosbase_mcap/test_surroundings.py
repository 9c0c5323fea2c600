"""What is different when a recording is replayed elsewhere."""

from types import SimpleNamespace

import pytest

from rosbase_mcap import surroundings
from rosbase_mcap.surroundings import differences


@pytest.mark.parametrize(
    ("recorded", "now", "expected"),
    [
        (["serial"], ["serial"], []),
        (["serial"], ["mqtt", "serial"], ["the transport mqtt is installed now"]),
        (["mqtt", "serial"], ["serial"], ["the transport mqtt is not installed"]),
        # An earlier version did not note them, and a file may be damaged.
        (None, ["serial"], []),
        ("serial", ["mqtt"], []),
    ],
)
def test_other_transports_are_named_because_a_reader_has_their_parameters(
    recorded: object, now: list[str], expected: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    installed = SimpleNamespace(transports=dict.fromkeys(now))
    monkeypatch.setattr(surroundings, "installed_plugins", lambda: installed)
    facts = {} if recorded is None else {"transports": recorded}
    named = [line for line in differences(facts, "") if "transport" in line]
    assert named == expected


def test_a_recording_notes_its_transports() -> None:
    noted = surroundings.surroundings()["transports"]
    assert noted == sorted(noted)
    assert not [line for line in differences({"transports": noted}, "") if "transport" in line]
