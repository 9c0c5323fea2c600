"""A program whose entries are recorded: the way of its trace into files."""

from pathlib import Path

import pytest

from rosbase import RecordOptions, make_logger
from rosbase.entries.kinds import Kind
from rosbase.entries.script import read_entries
from rosbase.entries.sink import EndFacts, RunFacts
from rosbase.entries.trace import Trace
from rosbase.entries.turn import Turn
from rosbase.messages import Vector3
from rosbase.testing import virtual_backend
from rosbase_mcap.channel_table import ORIGIN
from rosbase_mcap.program_recording import ProgramRecording
from rosbase_mcap.reading import messages
from rosbase_mcap.replaying.run_file import open_run

FACTS = RunFacts(1_700_000_000_000_000_000, 5, {"rate_hz": 20.0})


class Conducted:
    """As much of a conductor as a recording asks."""

    def __init__(self) -> None:
        self.turn, self.trace = Turn(), Trace()

    @property
    def is_inside(self) -> bool:
        return self.turn.is_mine


@pytest.mark.parametrize("split_bytes", [0, 2_000])
def test_a_trace_and_the_messages_of_its_entries_are_recorded(
    split_bytes: int, tmp_path: Path
) -> None:
    path = tmp_path / "run.mcap"
    backend, conducted = virtual_backend(), Conducted()
    recording = ProgramRecording(RecordOptions(path, split_bytes=split_bytes))
    assert recording.entries is not None
    recording.entries.begin(backend, conducted, conducted.trace, FACTS)  # type: ignore[arg-type]  # as said
    recording.begin(backend, make_logger("test"))
    publisher = backend.create_publisher(Vector3, "point", 10)
    conducted.turn.acquire()
    conducted.trace.begin(Kind.BEGIN, 0)
    for number in range(100):
        conducted.trace.begin(Kind.TICK, number, 0, 0)
        publisher.publish(Vector3(float(number)))
        if number % 20 == 0:
            recording._recorder.drain()  # type: ignore[union-attr]  # it has begun
    conducted.turn.release()
    publisher.publish(Vector3(-1.0))
    conducted.trace.begin(Kind.END, 100)
    end = EndFacts(102, "", ("a timer of a thread",))
    recording.entries.close(end)
    recording.close(None)
    backend.close()

    found = open_run(path)
    assert found is not None
    assert (len(found.paths) > 1) == (split_bytes > 0)
    assert found.run.facts.start_date_ns == FACTS.start_date_ns
    assert found.run.facts.more["rate_hz"] == 20.0
    assert found.run.facts.more["python"]
    entries = list(read_entries(found.blocks()))
    assert [entry.kind for entry in entries] == [Kind.BEGIN, *[Kind.TICK] * 100, Kind.END]
    outputs = list(found.outputs())
    assert [(one.number, one.topic) for one in outputs] == [(n + 1, "/point") for n in range(100)]
    assert found.end is not None
    assert found.end.facts == end
    outside = []
    for part in found.paths:
        with part.open("rb") as stream:
            outside += [one for one in messages(stream) if ORIGIN in one.channel.metadata]
    assert [one.channel.topic for one in outside] == ["/point"]


def test_a_ring_takes_no_entries(tmp_path: Path) -> None:
    recording = ProgramRecording(RecordOptions(tmp_path / "run.mcap", last_s=60.0))
    assert recording.entries is None
    recording.close(None)
