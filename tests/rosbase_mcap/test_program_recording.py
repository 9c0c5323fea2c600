"""A program that records itself."""

from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest

from rosbase import (
    BaseManager,
    BaseNode,
    LifecycleNode,
    RecordingError,
    RecordOptions,
    installed_plugins,
    make_logger,
)
from rosbase.messages import Vector3
from rosbase.messages.rcl_interfaces import Log, ParameterEvent
from rosbase.testing import virtual_backend
from rosbase.wire import deserialize
from rosbase_mcap.program_recording import ProgramRecording
from rosbase_mcap.reading import Entry, messages
from rosbase_mcap.recovery import is_complete


class Talker(BaseNode):
    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.declare_parameter("speed", 1.5)
        self.publisher = self.create_publisher(Vector3, "point", 10)
        # Before anything is spun, and before any thread looks for topics.
        self.publisher.publish(Vector3(-1.0))


class Robot(BaseManager):
    """Publishes in each tick, and ends after ten, in order or not."""

    def __init__(self, record: str | Path | RecordOptions, *, fails: bool = False) -> None:
        self.fails = fails
        super().__init__(
            "robot",
            {"talker": Talker, "arm": LifecycleNode},
            backend=virtual_backend(),
            record=record,
        )

    def update_timestamp(self) -> None:
        super().update_timestamp()
        self.node(Talker).publisher.publish(Vector3(float(self.timestamp)))
        if self.timestamp == 10:
            self.logger.warning("that was all")
            if self.fails:
                raise RuntimeError("fell over")
            self.request_stop()


def read(path: Path) -> list[Entry]:
    data = path.read_bytes()
    assert is_complete(BytesIO(data))
    return list(messages(BytesIO(data)))


def on(topic: str, entries: list[Entry]) -> list[bytes]:
    return [bytes(entry.message.data) for entry in entries if entry.channel.topic == topic]


@pytest.fixture
def backend() -> Iterator[Any]:
    made = virtual_backend()
    yield made
    made.close()


def test_a_manager_is_recorded_from_its_first_message_to_its_last(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    Robot(path).start_main_loop_timer()
    entries = read(path)
    points = [deserialize(data, Vector3).x for data in on("/point", entries)]
    assert points == [-1.0, *map(float, range(1, 11))]
    [event] = [deserialize(data, ParameterEvent) for data in on("/parameter_events", entries)]
    assert [one.name for one in event.new_parameters] == ["talker.speed"]
    assert on("/arm/transition_event", entries)
    lines = [deserialize(data, Log) for data in on("/rosout", entries)]
    assert [line.level for line in lines if line.msg == "that was all"] == [30]


def test_a_standalone_node_is_recorded(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    node = Talker(node_name="talker", backend=virtual_backend(), record=str(path))
    node.create_timer(0.5, node.request_stop)
    node.start_spin_standalone()
    assert len(on("/point", read(path))) == 1


def test_a_manager_that_was_never_started_leaves_a_whole_file(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    Robot(path).destroy_node()
    assert len(on("/point", read(path))) == 1


def test_a_constructor_that_fails_leaves_a_whole_file(tmp_path: Path) -> None:
    class Broken(BaseManager):
        def init_custom_variables(self) -> None:
            raise RuntimeError("no such arm")

    path = tmp_path / "run.mcap"
    with pytest.raises(RuntimeError, match="no such arm"):
        Broken("robot", backend=virtual_backend(), record=path)
    read(path)


def test_a_recording_in_memory_is_written_if_an_error_ends_the_program(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with pytest.raises(RuntimeError, match="fell over"):
        Robot(RecordOptions(path, last_s=60), fails=True).start_main_loop_timer()
    assert len(on("/point", read(path))) == 11


def test_a_recording_in_memory_is_not_written_if_the_program_ends_in_order(tmp_path: Path) -> None:
    Robot(RecordOptions(tmp_path / "run.mcap", last_s=60)).start_main_loop_timer()
    assert not list(tmp_path.iterdir())


def test_a_recording_in_memory_is_written_when_it_is_asked_for(
    tmp_path: Path, backend: Any
) -> None:
    recording = ProgramRecording(RecordOptions(tmp_path / "run.mcap", last_s=60))
    publisher = backend.create_publisher(Vector3, "point", 10)
    recording.begin(backend, make_logger("test"))
    publisher.publish(Vector3(1.0))
    assert recording.save() == tmp_path / "run.mcap"
    publisher.publish(Vector3(2.0))
    assert recording.save() == tmp_path / "run_1.mcap"
    recording.close(None)
    assert len(on("/point", read(tmp_path / "run.mcap"))) == 1
    assert len(on("/point", read(tmp_path / "run_1.mcap"))) == 2


def test_only_the_topics_that_were_chosen_are_recorded(tmp_path: Path, backend: Any) -> None:
    path = tmp_path / "run.mcap"
    recording = ProgramRecording(RecordOptions(path, topics=("wanted",)))
    recording.begin(backend, make_logger("test"))
    for name in ("wanted", "other"):
        backend.create_publisher(Vector3, name, 10).publish(Vector3(1.0))
    make_logger("test").warning("not chosen either")
    recording.close(None)
    recording.close(None)
    assert [entry.channel.topic for entry in read(path)] == ["/wanted"]


@pytest.mark.parametrize("last_s", [None, 60.0])
def test_a_file_is_never_overwritten(tmp_path: Path, last_s: float | None) -> None:
    path = tmp_path / "run.mcap"
    path.write_text("precious")
    with pytest.raises(RecordingError, match="there is such a file already"):
        Robot(RecordOptions(path, last_s=last_s))
    assert path.read_text() == "precious"


@pytest.mark.parametrize("last_s", [None, 60.0])
def test_a_folder_that_does_not_exist_is_an_error_at_the_start(
    tmp_path: Path, last_s: float | None
) -> None:
    with pytest.raises(RecordingError):
        Robot(RecordOptions(tmp_path / "none" / "run.mcap", last_s=last_s))


def test_an_unknown_compression_leaves_no_file(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="unknown compression 'zip'"):
        Robot(RecordOptions(tmp_path / "run.mcap", compression="zip"))
    assert not list(tmp_path.iterdir())


def test_the_recorder_is_found_by_the_suffix_of_the_file() -> None:
    assert installed_plugins().recorder("mcap").name == "mcap"
