"""Recordings of earlier versions are read and replayed by this one.

A test fails here if rosbase logs or publishes something else than the version that recorded the
file. Replays of users' own recordings then differ in the same way. If you want the change, describe
it in the changelog, and add a recording of the new version.
"""

from collections import Counter
from pathlib import Path

import pytest

from rosbase.entries.script import read_entries
from rosbase_mcap import replay
from rosbase_mcap.reading import messages
from rosbase_mcap.replaying.run_file import open_run
from support.golden.robot import Robot

FORMAT_1 = Path(__file__).parents[1] / "support" / "golden" / "format_1.mcap"
ENTRIES = 132
COUNTS = {
    "/arm/transition_event": 2,
    "/out": 22,
    "/own": 12,
    "/parameter_events": 8,
    "/point": 22,
    "/rosout": 7,
}
SHA256 = "777dedd7168ef1d201338883481beab427361d3990bd1679299599eea3912e63"


def test_each_entry_and_message_of_the_first_format_is_read() -> None:
    found = open_run(FORMAT_1)
    assert found is not None
    assert found.end is not None
    assert found.end.facts.entries == len(list(read_entries(found.blocks()))) == ENTRIES
    with FORMAT_1.open("rb") as stream:
        counts = Counter(one.channel.topic for one in messages(stream))
    assert counts == COUNTS


def test_the_program_of_the_first_format_repeats_its_recording(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("PYTHONHASHSEED", "7")
    caplog.set_level("INFO")
    run = replay(FORMAT_1, lambda: Robot().run())
    assert (run.difference, run.cut_short, run.error) == ("", "", None)
    assert run.sha256 == SHA256
