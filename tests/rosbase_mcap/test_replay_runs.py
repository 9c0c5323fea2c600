"""A program that is recorded while it runs, and replayed from the file."""

import errno
import os
import re
import signal
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rosbase import BaseManager, BaseNode, ConfigurationError, LifecycleNode, RecordOptions
from rosbase.entries.script import read_entries
from rosbase.messages import Vector3
from rosbase_mcap import replay
from rosbase_mcap.output_file import OutputFile
from rosbase_mcap.outputs import Digest, Output
from rosbase_mcap.records import Kind
from rosbase_mcap.replaying.options import ReplayOptions
from rosbase_mcap.replaying.run_file import open_run
from rosbase_mcap.replaying.session import Session
from rosbase_mcap.scanning import records_of

TICKS = 40
LONG = 300
# A program that differs from its recording ticks on time; on a busy machine, the recorded one was
# late. So it goes on until everything has come.
ENDLESS = 10_000


class Talker(BaseNode):
    """Publishes what depends on the order of timers, and on the clock."""

    gain = 1.0
    period_s = 0.007
    has_second_timer = True

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.declare_parameter("speed", 1.5)
        self.count = 0
        self.point = self.create_publisher(Vector3, "point", 10)
        self.out = self.create_publisher(Vector3, "out", 10)
        self.create_subscription(Vector3, "point", self.on_point, 10)
        self.create_timer(self.period_s, self.on_first)
        if self.has_second_timer:
            self.create_timer(0.017, self.on_second)

    def on_first(self) -> None:
        self.count += 1
        now_s = self.get_clock().monotonic_ns() / 1e9
        self.point.publish(Vector3(float(self.count), now_s, float(self.get_clock().now_ns())))

    def on_second(self) -> None:
        self.count = self.count * 2 % 1000
        self.logger.info(f"the count is {self.count}")
        self.set_parameter("speed", float(self.count))

    def on_point(self, message: Vector3) -> None:
        self.out.publish(Vector3(message.x * self.gain, message.y, message.z))


class Robot(BaseManager):
    """Has a thread of its own that publishes, and ends by itself."""

    fails = False
    ticks = TICKS
    rate_hz = 200.0

    def __init__(self, record: Path | RecordOptions | None = None) -> None:
        nodes = {"talker": Talker, "arm": LifecycleNode}
        super().__init__("robot", nodes, node_freq_hz=self.rate_hz, record=record)
        self.own = self.node(Talker).create_publisher(Vector3, "own", 10)
        self.is_over = threading.Event()

    def start(self) -> "Robot":
        thread = threading.Thread(target=self.publish, name="own")
        thread.start()
        try:
            self.start_main_loop_timer()
        finally:
            self.is_over.set()
            thread.join()
        return self

    def publish(self) -> None:
        number = 0
        while not self.is_over.wait(0.003):
            number += 1
            self.own.publish(Vector3(float(number)))

    def update_timestamp(self) -> None:
        super().update_timestamp()
        if self.timestamp == self.ticks:
            if self.fails:
                raise RuntimeError("fell over")
            self.request_stop()


def recorded(path: Path, **options: Any) -> Path:
    Robot(RecordOptions(path, **options)).start()
    return path


def replayed() -> None:
    Robot().start()


def replayed_as(robot: type[Robot], *arguments: Any) -> Callable[[], None]:
    def run() -> None:
        robot(*arguments).start()

    return run


@pytest.fixture
def path(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> Path:
    caplog.set_level("INFO")
    return recorded(tmp_path / "run.mcap")


@pytest.fixture(autouse=True)
def seed(monkeypatch: pytest.MonkeyPatch) -> None:
    # Nothing here depends on it.
    monkeypatch.setenv("PYTHONHASHSEED", "7")


def test_a_replay_equals_its_recording(path: Path) -> None:
    runs = [replay(path, replayed) for _ in range(2)]
    for run in runs:
        assert (run.difference, run.cut_short, run.error) == ("", "", None)
    found = open_run(path)
    assert found is not None
    assert found.end is not None
    digest = Digest()
    for one in found.outputs():
        digest.add(one.number, one.topic, one.data)
    assert {run.sha256 for run in runs} == {digest.hexdigest}
    assert found.end.facts.spoiled == ()
    run = runs[0]
    assert len(run.topic("out")) > 10
    assert [message.x for message in run.topic("own")][:3] == [1.0, 2.0, 3.0]
    assert [node for node, _ in run.transitions] == ["/arm"] * len(run.transitions)
    assert run.transitions
    assert any(event.changed_parameters for event in run.parameters)
    assert any("the count is" in line.msg for line in run.log)
    assert 0 <= run.stamped("out")[0][0] < 60


def test_a_change_in_a_handler_is_found_with_topic_time_and_field(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Talker, "gain", 1 + 1e-9)
    lines = replay(path, replayed).difference.splitlines()
    assert re.fullmatch(r"first difference at 00:\d\d\.\d{3}, entry \d+, /out", lines[0])
    assert lines[1] == "    x: 1.0 -> 1.000000001   (recorded -> replayed)"
    assert lines[2] == "    2 other fields are equal"
    assert "a call" in lines[3]


def test_a_timer_that_is_gone_is_found_and_the_replay_goes_on(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Talker, "has_second_timer", False)
    monkeypatch.setattr(Robot, "ticks", ENDLESS)
    run = replay(path, replayed)
    assert "Talker.on_second" in run.difference
    # What came from outside still comes.
    assert len(run.topic("own")) > 10
    assert len(run.topic("out")) > 10


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("rate_hz", 100, "the main loop has rate 100 Hz, recorded 200 Hz"),
        ("period_s", 0.07, "timer Talker.on_first has period 0.07 s, recorded 0.007 s"),
    ],
)
def test_another_rate_or_period_is_a_difference(
    name: str, value: float, text: str, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Robot if name == "rate_hz" else Talker, name, value)
    monkeypatch.setattr(Robot, "ticks", ENDLESS)
    run = replay(path, replayed)
    assert run.difference.splitlines()[0].endswith(text)
    assert len(run.topic("own")) > 10


def test_an_error_that_ends_the_program_is_repeated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.mcap"
    monkeypatch.setattr(Robot, "fails", True)
    with pytest.raises(RuntimeError, match="fell over"):
        recorded(path)
    run = replay(path, replayed)
    assert (repr(run.error), run.difference) == ("RuntimeError('fell over')", "")
    monkeypatch.setattr(Robot, "fails", False)
    assert replay(path, replayed).difference


def test_a_recording_that_was_cut_off_is_replayed_up_to_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Longer than the time between two writes.
    monkeypatch.setattr(Robot, "ticks", LONG)
    path = recorded(tmp_path / "run.mcap")
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * 0.6)])
    run = replay(path, replayed)
    assert run.difference == ""
    assert "killed" in run.cut_short
    assert len(run.topic("own")) > 10
    path.write_bytes(data[:2_000])
    with pytest.raises(ConfigurationError, match="has no entry: its program was killed"):
        replay(path, replayed)


def test_a_damaged_chunk_is_named_as_a_reason_for_a_difference(path: Path) -> None:
    with path.open("rb") as stream:
        first = next(found for found in records_of(stream) if found.kind == Kind.CHUNK)
    data = bytearray(path.read_bytes())
    data[first.end - 1] ^= 1
    path.write_bytes(data)
    assert "1 damaged chunk" in replay(path, replayed).difference.splitlines()[-1]


def test_damaged_entries_cut_a_replay_short(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Longer than the time between two blocks of entries.
    monkeypatch.setattr(Robot, "ticks", LONG)
    path = recorded(tmp_path / "run.mcap")
    with path.open("rb") as stream:
        blocks = [found for found in records_of(stream) if found.kind == Kind.ATTACHMENT]
    data = bytearray(path.read_bytes())
    data[blocks[-1].end - 30] ^= 0xFF
    path.write_bytes(data)
    assert replay(path, replayed).cut_short == "the entries behind that are missing or damaged"
    data[blocks[0].end - 30] ^= 0xFF
    path.write_bytes(data)
    with pytest.raises(ConfigurationError, match="has no entry: its first entries are damaged"):
        replay(path, replayed)


def test_parts_of_a_recording_are_replayed_as_one(tmp_path: Path) -> None:
    path = recorded(tmp_path / "run.mcap", split_bytes=1_000)
    run = replay(path, replayed)
    assert (run.difference, run.cut_short) == ("", "")


def test_topics_that_were_not_recorded_are_not_compared(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = recorded(tmp_path / "run.mcap", topics=("point",))
    run = replay(path, replayed)
    assert (run.difference, run.topics) == ("", ["/point"])
    monkeypatch.setattr(Talker, "gain", 2.0)
    assert replay(path, replayed).difference == ""


def test_an_error_that_did_not_end_the_recorded_program_is_raised(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Robot, "fails", True)
    with pytest.raises(RuntimeError, match="fell over"):
        replay(path, replayed)


class Unbuildable(Robot):
    """Fails in its constructor."""

    def __init__(self, record: Path | None = None) -> None:
        super().__init__(record)
        raise RuntimeError("no arm")


def test_an_error_in_the_constructor_is_repeated_or_raised(tmp_path: Path, path: Path) -> None:
    failed = tmp_path / "failed.mcap"
    with pytest.raises(RuntimeError):
        Unbuildable(failed)
    run = replay(failed, replayed_as(Unbuildable))
    assert (repr(run.error), run.difference) == ("RuntimeError('no arm')", "")
    # The recorded program had none.
    with pytest.raises(RuntimeError, match="no arm"):
        replay(path, Unbuildable)


class Abrupt(Robot):
    """Ends by something that is no Exception, or stops itself by a signal."""

    signal = 0

    def update_timestamp(self) -> None:
        super().update_timestamp()
        if self.timestamp == self.ticks // 2:
            if not self.signal:
                raise GeneratorExit("at once")
            os.kill(os.getpid(), self.signal)


def test_an_end_by_no_exception_is_repeated(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with pytest.raises(GeneratorExit):
        Abrupt(path).start()
    run = replay(path, replayed_as(Abrupt))
    assert (repr(run.error), run.difference) == ("GeneratorExit('at once')", "")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_program_that_stops_itself_by_a_signal_is_replayed_to_its_end(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Abrupt, "signal", number)
    path = tmp_path / "run.mcap"
    Abrupt(path).start()
    run = replay(path, replayed_as(Abrupt))
    assert (run.difference, run.cut_short) == ("", "")


def test_a_changed_program_that_ends_earlier_is_a_difference(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Robot, "ticks", TICKS // 2)
    run = replay(path, replayed)
    assert "the program ends at 00:" in run.difference
    assert "and the recording goes on to 00:" in run.difference
    assert run.cut_short == ""


def test_a_recording_that_has_filled_the_disk_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain, blocks = OutputFile.write, list[bytes]()

    def write(file: OutputFile, data: bytes) -> None:
        if len(blocks) == 2 and data[0] == Kind.CHUNK:
            raise OSError(errno.ENOSPC, "No space left on device")
        plain(file, data)
        if b"rosbase/trace/" in data:
            blocks.append(data)

    monkeypatch.setattr(Robot, "ticks", LONG)
    with monkeypatch.context() as patch:
        patch.setattr(OutputFile, "write", write)
        path = recorded(tmp_path / "run.mcap")
    run = replay(path, replayed)
    assert run.difference == ""
    assert run.cut_short == "the recording has no end: [Errno 28] No space left on device"


@pytest.mark.parametrize("share", [0.0, 0.3, 0.7])
def test_a_replay_ends_with_the_last_entry_that_began_in_time(share: float, path: Path) -> None:
    found = open_run(path)
    assert found is not None
    entries, outputs = list(read_entries(found.blocks())), list(found.outputs())
    end_ns = entries[int(len(entries) * share)].t_ns
    last = [entry for entry in entries if entry.t_ns <= end_ns][-1]
    heard: list[Output] = []
    options = ReplayOptions(path, rate=None, end_ns=end_ns, checks=True)
    session = Session(options, heard.append)
    with session.conducting():
        replayed()
    assert (session.outcome.difference, session.outcome.cut_short) == (None, "")
    in_time = [one for one in outputs if one.number <= last.number]
    assert [(one.number, one.topic) for one in heard] == [(o.number, o.topic) for o in in_time]
    assert len(in_time) < len(outputs)


def test_a_misspelt_topic_is_an_error_that_names_the_topics(path: Path) -> None:
    run = replay(path, replayed)
    for call in (run.topic, run.stamped):
        with pytest.raises(ConfigurationError, match=r"no topic /nosuch .* /out, .*/point"):
            call("nosuch")
    run = replay(path, replayed, keep=["out"])
    assert (run.log, run.parameters) == ([], [])
    with pytest.raises(ConfigurationError, match=r"no topic /point .* there are: /out$"):
        run.topic("point")


def test_only_chosen_topics_are_kept_in_memory(path: Path) -> None:
    run = replay(path, replayed, keep=["out"])
    assert run.topics == ["/out"]
    assert run.difference == ""


def test_the_name_of_a_program_is_refused(path: Path) -> None:
    name: Any = "robot.py"
    with pytest.raises(ConfigurationError, match=r"'robot\.py' is no class and no function"):
        replay(path, name)


def test_a_function_without_a_program_is_refused(path: Path) -> None:
    nothing: Callable[[], object] = os.getcwd
    with pytest.raises(ConfigurationError, match="is no manager and no standalone node"):
        replay(path, nothing)


class Endless(Robot):
    """Ends when it is asked to."""

    ticks = 0


def test_its_topics_drive_a_program_too(path: Path) -> None:
    # By its own ticks, it might end before the first of them: its constructor takes no time now.
    run = replay(path, replayed_as(Endless), topics=["point"])
    points = run.topic("point")
    assert len(points) > 10
    assert replay(path, replayed).topic("point") == points
    assert len(run.topic("out")) == len(points)


class Lone(Talker):
    """Runs without a manager."""

    def on_first(self) -> None:
        super().on_first()
        if self.count > 100:
            self._request_stop()


def test_a_standalone_node_is_replayed(tmp_path: Path) -> None:
    path = tmp_path / "lone.mcap"
    Lone(node_name="lone", record=path).start_spin_standalone()
    run = replay(path, lambda: Lone(node_name="lone"))
    assert (run.difference, run.cut_short) == ("", "")
    assert len(run.topic("out")) > 3


class Careless(Robot):
    """Creates a timer on a thread of its own, where nobody knows when."""

    def publish(self) -> None:
        if not self.is_over.wait(0.05):
            self.node(Talker).create_timer(60.0, print)
        super().publish()


def test_a_recording_that_was_spoiled_is_replayed_up_to_there(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "run.mcap"
    Careless(path).start()
    assert "can be replayed only in part: thread 'own'" in caplog.text
    run = replay(path, replayed_as(Careless))
    assert run.difference == ""
    assert "thread 'own'" in run.cut_short


def test_a_program_that_would_record_itself_does_not_in_a_replay(path: Path) -> None:
    again = path.with_name("again.mcap")
    run = replay(path, replayed_as(Robot, again))
    assert run.difference == ""
    assert not again.exists()


class Opaque:
    """Has no schema."""


class Secretive(Robot):
    """Has a topic, and another with a message, that cannot be recorded."""

    def __init__(self, record: Path | None = None) -> None:
        super().__init__(record)
        node, wrong = self.node(Talker), Vector3()
        node.create_publisher(Opaque, "opaque", 10).publish(Opaque())
        object.__setattr__(wrong, "x", "text")
        node.create_publisher(Vector3, "wrong", 10).publish(wrong)


def test_what_cannot_be_recorded_is_no_difference(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "run.mcap"
    Secretive(path).start()
    assert "/opaque is not recorded" in caplog.text
    assert "a message of /wrong is not recorded" in caplog.text
    run = replay(path, replayed_as(Secretive))
    assert (run.difference, run.cut_short) == ("", "")
    assert not [line.msg for line in run.log if "not recorded" in line.msg]
