"""The seams for recorders: how one is chosen, when it begins and ends, and what it can hear."""

from pathlib import Path
from typing import Any

import pytest

from rosbase import (
    Backend,
    BaseManager,
    BaseNode,
    ConfigurationError,
    NotInstalledError,
    PluginRegistry,
    RecordingError,
    RecordOptions,
    RosbaseLogger,
    TopicEnd,
    make_logger,
)
from rosbase.contracts.new_ends import NewEnds
from rosbase.logger.observer import add_observer, remove_observer
from rosbase.messages import Vector3
from rosbase.roles import recording as roles_recording
from rosbase.roles.recording import RECORD_VARIABLE
from rosbase.testing import virtual_backend


class Recorded:
    """A recording that notes what happens to it."""

    def __init__(self, options: RecordOptions) -> None:
        self.options = options
        self.ends: list[TopicEnd] = []
        self.events: list[str] = []

    def begin(self, backend: Backend, logger: RosbaseLogger) -> None:
        self.events.append(f"begin {backend.node_name}")
        backend.new_ends.add(self.ends.append)

    def save(self) -> Path:
        return self.options.path

    def close(self, error: BaseException | None) -> None:
        self.events.append(f"close {error!r}")


class Recorders:
    """The registry, with one recorder."""

    def __init__(self) -> None:
        self.made: list[Recorded] = []
        self.name = "none"

    def recorder(self, name: str) -> Any:
        self.name = name
        return self

    def open(self, options: RecordOptions) -> Recorded:
        self.made.append(Recorded(options))
        return self.made[-1]


@pytest.fixture
def recorders(monkeypatch: pytest.MonkeyPatch) -> Recorders:
    made = Recorders()
    monkeypatch.setattr("rosbase.plugins.installed_plugins", lambda: made)
    monkeypatch.setattr(roles_recording, "_is_taken", False)
    return made


class Robot(BaseManager):
    def main_loop(self) -> None:
        if self.state == "broken":
            raise RuntimeError("fell over")
        self.request_stop()


def test_the_suffix_of_the_file_chooses_the_recorder(recorders: Recorders) -> None:
    robot = Robot("robot", backend=virtual_backend(), record="run.mcap")
    assert recorders.name == "mcap"
    [made] = recorders.made
    assert made.options == RecordOptions("run.mcap")
    assert robot.recording is made
    robot.destroy_node()


def test_a_recording_spans_the_whole_program(recorders: Recorders) -> None:
    class Talker(BaseNode):
        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)
            self.create_publisher(Vector3, "point", 10)

        def release_resources(self) -> None:
            assert recorders.made[0].events == ["begin test"]

    Robot(
        "robot", {"talker": Talker}, backend=virtual_backend(), record="run.mcap"
    ).start_main_loop()
    [made] = recorders.made
    assert [end.name for end in made.ends] == ["/point"]
    assert made.events == ["begin test", "close None"]


def test_a_recording_knows_what_has_ended_the_program(recorders: Recorders) -> None:
    robot = Robot("robot", backend=virtual_backend(), record="run.mcap", start_state="broken")
    with pytest.raises(RuntimeError):
        robot.start_main_loop()
    assert recorders.made[0].events[-1] == "close RuntimeError('fell over')"


def test_a_recording_ends_with_a_constructor_that_fails(recorders: Recorders) -> None:
    class Broken(BaseNode):
        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)
            raise RuntimeError("no such arm")

    with pytest.raises(RuntimeError):
        Robot("robot", {"arm": Broken}, backend=virtual_backend(), record="run.mcap")
    with pytest.raises(RuntimeError):
        Broken(backend=virtual_backend(), record="run.mcap")
    for made in recorders.made:
        assert made.events[-1] == "close RuntimeError('no such arm')"


def test_the_environment_has_the_first_program_recorded(
    recorders: Recorders, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    wanted = RecordOptions("run.mcap", last_s=60.0)
    monkeypatch.setenv(RECORD_VARIABLE, wanted.to_text())
    first = Robot("first", backend=virtual_backend())
    with caplog.at_level("INFO"):
        second = Robot("second", backend=virtual_backend())
    assert [made.options for made in recorders.made] == [wanted]
    assert second.recording is None
    assert "this program is not recorded" in caplog.text
    first.destroy_node()
    second.destroy_node()


def test_a_child_does_not_record_itself(
    recorders: Recorders, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(RECORD_VARIABLE, "run.mcap")
    monkeypatch.setattr(roles_recording, "is_child", lambda: True)
    robot = Robot("robot", backend=virtual_backend())
    assert not recorders.made
    robot.destroy_node()


def test_a_recorder_that_is_not_installed_is_named_with_its_package() -> None:
    with pytest.raises(NotInstalledError, match="recorder 'mcap' needs the package rosbase-mcap"):
        PluginRegistry([]).recorder("mcap")


@pytest.mark.parametrize("record", ["run", RecordOptions("run")])
def test_a_file_without_a_suffix_is_refused(record: Any) -> None:
    with pytest.raises(ConfigurationError, match=r"a recording has a suffix, such as \.mcap"):
        Robot("robot", backend=virtual_backend(), record=record)


def test_record_is_a_path_or_options() -> None:
    record: Any = 5
    with pytest.raises(TypeError, match="record is a path or RecordOptions, not 5"):
        Robot("robot", backend=virtual_backend(), record=record)


def test_options_survive_the_environment() -> None:
    options = RecordOptions("a b.mcap", ("/x",), 1.5, 10, 2.5, "lz4")
    assert RecordOptions.from_text(options.to_text()) == options
    assert RecordOptions.from_text("a b.mcap") == RecordOptions("a b.mcap")
    for text in ("{", '{"path": "x", "colour": 1}'):
        with pytest.raises(ConfigurationError):
            RecordOptions.from_text(text)


@pytest.mark.parametrize("field", ["last_s", "split_bytes", "split_s"])
def test_options_are_not_negative(field: str) -> None:
    values: dict[str, Any] = {field: -1}
    with pytest.raises(ConfigurationError, match=f"{field} of a recording is not -1"):
        RecordOptions("run.mcap", **values)


def test_new_ends_are_told_before_their_first_message() -> None:
    backend = virtual_backend()
    heard: list[Any] = []

    def listen(end: TopicEnd) -> None:
        ends.append(end)
        backend.add_tap(end.name, heard.append)

    ends: list[TopicEnd] = []
    backend.new_ends.add(listen)
    backend.create_publisher(Vector3, "point", 10).publish(Vector3(1.0))
    backend.create_subscription(Vector3, "other", print, 10)
    backend.new_ends.remove(listen)
    backend.create_publisher(Vector3, "third", 10)
    assert [(end.name, end.type_name, end.msg_type) for end in ends] == [
        ("/point", "geometry_msgs/msg/Vector3", Vector3),
        ("/other", "geometry_msgs/msg/Vector3", Vector3),
    ]
    assert heard == [Vector3(1.0)]
    backend.close()


def test_without_a_listener_no_end_is_described() -> None:
    def describe() -> TopicEnd:
        raise AssertionError

    NewEnds().tell(describe)


def test_a_backend_knows_the_connections_of_its_nodes() -> None:
    class Talker(BaseNode):
        pass

    robot = Robot("robot", {"talker": Talker}, backend=virtual_backend())
    talker = robot.node(Talker)
    assert robot.backend.connections == [robot.backend, talker._connection]
    robot.destroy_node()


def test_several_functions_hear_the_log() -> None:
    heard: list[tuple[int, str]] = []
    first, second = (
        (lambda record: heard.append((1, record.msg))),
        (lambda record: heard.append((2, record.msg))),
    )
    logger = make_logger("test")
    add_observer(first)
    add_observer(second)
    logger.warning("one")
    remove_observer(first)
    remove_observer(first)
    logger.warning("two")
    remove_observer(second)
    logger.warning("three")
    assert heard == [(1, "one"), (2, "one"), (2, "two")]


def test_errors_of_recordings_are_usage_errors() -> None:
    assert issubclass(RecordingError, ConfigurationError)
