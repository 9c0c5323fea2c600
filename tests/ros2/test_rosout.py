"""What a program logs, on `/rosout` and on the console."""

import logging
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import rclpy
from rcl_interfaces.msg import Log
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from std_msgs.msg import String as RosString

from rosbase import BaseManager, BaseNode
from rosbase.contracts.backend import BackendOptions
from rosbase.logger import RosbaseLogger
from rosbase_ros2.backend import Ros2Backend
from support.log_lines import without_times
from support.waiting import wait_until

LATCHED = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Listener:
    """A plain rclpy subscriber of `/rosout`."""

    def __init__(self, context: Any) -> None:
        self.node: Any = rclpy.create_node("listener", context=context)
        self.executor: Any = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)
        self.heard: list[Any] = []
        self.node.create_subscription(Log, "/rosout", self.heard.append, LATCHED)

    def await_text(self, name: str, last: str, *, alone: bool = False) -> list[Any]:
        """The records of that node, or those with that text, when one with it is here."""

        def arrived() -> bool:
            self.executor.spin_once(timeout_sec=0.02)
            return any((record.name, record.msg) == (name, last) for record in self.heard)

        wait_until(arrived, f"{last!r} of {name}, not {self.heard}")
        records = [record for record in self.heard if record.name == name]
        return [record for record in records if not alone or record.msg == last]


@pytest.fixture
def listener(context: Any) -> Iterator[Listener]:
    listener = Listener(context)
    yield listener
    listener.executor.shutdown()
    listener.node.destroy_node()


@pytest.fixture
def start() -> Iterator[Callable[..., Ros2Backend]]:
    """Opens backends by the name of their node."""
    opened: list[Ros2Backend] = []

    def start(name: str) -> Ros2Backend:
        opened.append(Ros2Backend(BackendOptions(name)))
        return opened[-1]

    yield start
    for backend in opened:
        backend.close()


@pytest.fixture(autouse=True)
def everything_is_logged(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.DEBUG, logger="rosbase")


PROGRAM = """
import sys
from rosbase.contracts.backend import BackendOptions
from rosbase.roles.lifecycle_node import LifecycleNode
from rosbase_ros2.backend import Ros2Backend

class Walker(LifecycleNode):
    def on_configure(self, previous_state):
        self.logger.debug("looking")
        self.logger.info("100 % ready")
        for _ in range(2):
            self.logger.warning("hot", once=True)
        raise OSError("no such device")

backend = Ros2Backend(BackendOptions("walker"))
walker = Walker(node_name="walker", backend=backend)
rosout = backend.log_handler.publisher
print([types for _, types in backend.node.get_publisher_names_and_types_by_node("walker", "/")])
while "wait" in sys.argv and not rosout.get_subscription_count():
    backend.spin_once(0.05)
walker.trigger_configure()
walker.logger.info("end")
backend.close()
walker.logger.info("after the end")
"""


@contextmanager
def running(
    tmp_path: Path, *arguments: str, source: str = PROGRAM
) -> "Iterator[subprocess.Popen[str]]":
    """The program, which has ended afterwards."""
    program = tmp_path / "program.py"
    program.write_text(source)
    with subprocess.Popen(
        [sys.executable, str(program), *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def run(tmp_path: Path, *arguments: str) -> tuple[str, str]:
    """What the program writes to stdout, and to the console."""
    with running(tmp_path, *arguments) as program:
        out, console = program.communicate(timeout=30)
    assert program.returncode == 0, console
    return out, console


def test_what_a_program_logs_is_on_rosout_once_and_on_the_console_once(
    listener: Listener, tmp_path: Path
) -> None:
    started = int(time.time())
    with running(tmp_path, "wait") as program:
        listener.await_text("walker", "end")
        _, console = program.communicate(timeout=30)
    for _ in range(10):
        listener.executor.spin_once(timeout_sec=0.02)
    records = listener.await_text("walker", "end")
    assert [(r.level, r.msg.splitlines()[0]) for r in records] == [
        (20, "100 % ready"),
        (30, "hot"),
        (40, "on_configure raised OSError: no such device"),
        (20, "end"),
    ]
    failure = records[2].msg
    assert failure.count("Traceback (most recent call last)") == 1
    assert failure.endswith("OSError: no such device")
    assert (records[0].file, records[0].function) == (str(tmp_path / "program.py"), "on_configure")
    assert PROGRAM.splitlines()[records[0].line - 1].strip() == 'self.logger.info("100 % ready")'
    assert started <= records[0].stamp.sec <= records[3].stamp.sec <= time.time()
    assert without_times(console) == "".join(
        f"[{level}] [walker]: {text}\n"
        for level, text in (
            ("INFO", "100 % ready"),
            ("WARN", "hot"),
            ("ERROR", failure),
            ("INFO", "end"),
            ("INFO", "after the end"),
        )
    )


@pytest.mark.parametrize(
    ("level", "said"),
    [
        ("debug", ["looking", "100 % ready", "hot"]),
        ("walker:=debug", ["looking", "100 % ready", "hot"]),
        ("other:=debug", ["100 % ready", "hot"]),
        ("walker:=warn", ["hot"]),
    ],
)
def test_the_log_level_of_ros_decides_where_the_program_says_nothing(
    tmp_path: Path, level: str, said: list[str]
) -> None:
    _, console = run(tmp_path, "--ros-args", "--log-level", level)
    lines = [line.rpartition(": ")[2] for line in console.splitlines() if "] [walker]: " in line]
    assert [line for line in lines if line in ("looking", "100 % ready", "hot")] == said


def test_disabled_logs_go_to_the_console_alone(tmp_path: Path) -> None:
    out, console = run(tmp_path, "--ros-args", "--disable-rosout-logs")
    assert "rcl_interfaces/msg/ParameterEvent" in out
    assert "rcl_interfaces/msg/Log" not in out
    assert "[INFO] [walker]: 100 % ready\n" in without_times(console)


def test_a_node_has_one_publisher_as_any_ros_node(
    start: Callable[..., Ros2Backend], listener: Listener
) -> None:
    backend = start("any")

    def publishers_of(name: str) -> list[Any]:
        found = backend.node.get_publishers_info_by_topic("/rosout")
        return [end for end in found if end.node_name == name]

    wait_until(lambda: publishers_of("listener"), "the publisher of rcl")
    (ours,), (rcls, *_) = publishers_of("any"), publishers_of("listener")
    assert rcls.qos_profile == ours.qos_profile
    assert ours.qos_profile.lifespan.nanoseconds == 10_000_000_000


NATIVE = """
import sys
from rosbase import BackendOptions, BaseNode
from rosbase_ros2.backend import Ros2Backend

backend = Ros2Backend(BackendOptions("walker"))
node = BaseNode(backend=backend, node_name="walker")
rosout = backend.log_handler.publisher
while "wait" in sys.argv and not rosout.get_subscription_count():
    backend.spin_once(0.05)
logger = backend.node.get_logger()
logger.debug("looking")
for _ in range(2):
    logger.info("ready", once=True)
logger.get_child("leg").warning("bent")
logger.get_child("leg").get_child("foot").error("cold")
node.logger.info("end")
backend.close()
logger.fatal("after the end")
"""


@pytest.mark.parametrize(
    ("arguments", "looks"), [([], False), (["--log-level", "walker:=debug"], True)]
)
def test_what_native_code_logs_is_on_rosout_once_and_on_the_console_once(
    listener: Listener, tmp_path: Path, arguments: list[str], looks: bool
) -> None:
    with running(tmp_path, "wait", "--ros-args", *arguments, source=NATIVE) as program:
        listener.await_text("walker", "end")
        _, console = program.communicate(timeout=30)
    for _ in range(10):
        listener.executor.spin_once(timeout_sec=0.02)
    records = [record for record in listener.heard if record.name.startswith("walker")]
    expected = [
        *([(10, "walker", "looking")] if looks else []),
        (20, "walker", "ready"),
        (30, "walker.leg", "bent"),
        (40, "walker.leg.foot", "cold"),
        (20, "walker", "end"),
    ]
    assert [(r.level, r.name, r.msg) for r in records] == expected
    bent = next(record for record in records if record.msg == "bent")
    assert (bent.file, bent.function) == (str(tmp_path / "program.py"), "<module>")
    assert NATIVE.splitlines()[bent.line - 1] == 'logger.get_child("leg").warning("bent")'
    levels = {10: "DEBUG", 20: "INFO", 30: "WARN", 40: "ERROR", 50: "FATAL"}
    lines = [line for line in console.splitlines() if "] [walker" in line]
    assert without_times("\n".join(lines)).splitlines() == [
        f"[{levels[level]}] [{name}]: {text}"
        for level, name, text in (*expected, (50, "walker", "after the end"))
    ]


def test_disabled_logs_of_native_code_go_to_the_console_alone(
    listener: Listener, tmp_path: Path
) -> None:
    with running(tmp_path, "--ros-args", "--disable-rosout-logs", source=NATIVE) as program:
        out, console = program.communicate(timeout=30)
    assert (program.returncode, out) == (0, ""), console
    assert "[INFO] [walker]: ready\n" in without_times(console)
    assert "walker" not in {record.name for record in listener.heard}


@pytest.mark.parametrize("creator", ["rosbase", "native"])
def test_ends_of_a_topic_that_do_not_match_are_on_rosout(
    start: Callable[..., Ros2Backend], listener: Listener, creator: str
) -> None:
    backend = start("strict")
    node = backend if creator == "rosbase" else backend.node
    node.create_subscription(RosString, "asked", lambda message: None, LATCHED)
    node.create_publisher(RosString, "offered", qos_profile_sensor_data)
    listener.node.create_publisher(RosString, "asked", 10)
    listener.node.create_subscription(RosString, "offered", lambda message: None, 10)
    (asked,) = listener.await_text(
        "strict",
        "New publisher discovered on topic 'asked', offering incompatible QoS. No messages will be"
        " received from it. Last incompatible policy: DURABILITY",
        alone=True,
    )
    (offered,) = listener.await_text(
        "strict",
        "New subscription discovered on topic 'offered', requesting incompatible QoS. No messages"
        " will be sent to it. Last incompatible policy: RELIABILITY",
        alone=True,
    )
    assert (asked.level, offered.level) == (30, 30)


def test_two_backends_in_one_process_publish_their_own_records_only(
    start: Callable[..., Ros2Backend], listener: Listener
) -> None:
    nodes = {name: BaseNode(node_name=name, backend=start(name)) for name in ("left", "right")}
    for name, node in nodes.items():
        node.logger.info(f"I am {name}")
        node.logger.info("end")
    for name in nodes:
        assert [r.msg for r in listener.await_text(name, "end")] == [f"I am {name}", "end"]


class OwnLogger:
    """A program's own logger, which writes nowhere that anybody sees."""

    def __init__(self, name: str) -> None:
        self.lines: list[str] = []

    def info(self, message: str, colour: str = "") -> None:
        self.lines.append(message)

    debug = warning = error = critical = info

    def log_once(self, message: str, level: str = "INFO") -> None:
        if message not in self.lines:
            self.lines.append(message)


def test_what_goes_to_a_custom_logger_is_on_rosout_too(
    start: Callable[..., Ros2Backend], listener: Listener
) -> None:
    manager = BaseManager("boss", custom_logger=OwnLogger, backend=start("boss"))
    say_in_green: Any = manager.logger.info
    manager.logger.debug("below the level")
    say_in_green("here", "green")
    for _ in range(2):
        manager.logger.log_once("once", "WARNING")
    manager.logger.important("goal")
    try:
        raise OSError("gone")
    except OSError:
        manager.logger.error("lost", exc_info=True)
    manager.logger.critical("end")
    records = listener.await_text("boss", "end")
    assert [(r.level, r.msg.splitlines()[0]) for r in records] == [
        (20, "here"),
        (30, "once"),
        (20, "*** goal ***"),
        (40, "lost"),
        (50, "end"),
    ]
    assert records[3].msg.endswith("OSError: gone")
    assert records[0].file == __file__


def test_a_program_that_sets_up_logging_decides_about_levels(
    start: Callable[..., Ros2Backend], listener: Listener
) -> None:
    logger = BaseNode(node_name="strict", backend=start("strict")).logger
    logging.getLogger("rosbase").setLevel("ERROR")
    logger.warning("not asked for")
    logging.getLogger("rosbase").setLevel("DEBUG")
    logger.debug("asked for")
    logger.error("end")
    assert [r.msg for r in listener.await_text("strict", "end")] == ["asked for", "end"]


def test_records_come_from_any_thread_and_from_callbacks_of_rclpy(
    start: Callable[..., Ros2Backend], listener: Listener
) -> None:
    backend = start("busy")
    logger: Any = BaseNode(node_name="busy", backend=backend).logger
    timer = backend.node.create_timer(0.001, lambda: logger.info("from rclpy", once=True))
    threads = [
        threading.Thread(target=lambda n=number: [logger.info(f"{n} {i}") for i in range(50)])
        for number in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    listener.await_text("busy", "from rclpy")
    timer.cancel()
    logger.info("end")
    texts = sorted(r.msg for r in listener.await_text("busy", "end"))
    assert texts == sorted(
        ["end", "from rclpy", *(f"{n} {i}" for n in range(4) for i in range(50))]
    )


def test_a_callback_of_rclpy_that_fails_is_on_rosout(
    start: Callable[..., Ros2Backend], listener: Listener
) -> None:
    backend = start("wild")
    backend.node.create_subscription(RosString, "wild", lambda message: 1 / 0, 10)
    publisher = backend.node.create_publisher(RosString, "wild", 10)
    wait_until(publisher.get_subscription_count, "the subscription to be found")
    publisher.publish(RosString())
    (record,) = listener.await_text(
        "wild", "a callback of rclpy raised ZeroDivisionError: division by zero"
    )
    assert record.level == 40


def test_text_and_levels_that_ros_does_not_know_arrive_as_near_as_can_be(
    start: Callable[..., Ros2Backend], listener: Listener
) -> None:
    backend = start("odd")
    RosbaseLogger("odd", listener=backend.log_handler).info("a\0b \ud800 \u00e9")
    assert backend.log_handler is not None
    for level in (1, 25, 400):
        backend.log_handler.handle(logging.LogRecord("odd", level, "f", 1, str(level), None, None))
    records = listener.await_text("odd", "400")
    assert [(r.level, r.msg) for r in records] == [
        (20, "a\\x00b \\ud800 \u00e9"),
        (10, "1"),
        (20, "25"),
        (50, "400"),
    ]


@pytest.mark.parametrize("end", ["backend", "context"])
def test_who_logs_after_the_end_is_not_troubled(
    start: Callable[..., Ros2Backend],
    caplog: pytest.LogCaptureFixture,
    capfd: pytest.CaptureFixture[str],
    end: str,
) -> None:
    backend = start(f"without_{end}")
    logger = BaseNode(node_name="late", backend=backend).logger
    if end == "backend":
        backend.close()
    else:
        backend.node.context.shutdown()
    logger.error("too late")
    assert caplog.messages == ["too late"]
    assert capfd.readouterr().err == ""


def test_a_context_that_the_program_ends_ends_the_thread_that_takes_in(
    start: Callable[..., Ros2Backend], caplog: pytest.LogCaptureFixture
) -> None:
    backend = start("cut_off")
    backend.node.context.shutdown()
    wait_until(
        lambda: "rclpy" not in [thread.name for thread in threading.enumerate()], "the thread"
    )
    assert caplog.messages == []


def test_outside_text_is_one_line_and_a_traceback_stands_indented_below_it(
    start: Callable[..., Ros2Backend], listener: Listener
) -> None:
    backend = start("lines")
    logger = RosbaseLogger("lines", listener=backend.log_handler)
    forged = "a\n[INFO] [boss]: all is well\x1b[2J\u202e"
    logger.warning(forged)
    logger.error("broken", exc_info=ValueError(forged))
    logger.info("end")
    said, broken, _ = (record.msg for record in listener.await_text("lines", "end"))
    assert said == r"a\n[INFO] [boss]: all is well\x1b[2J\u202e"
    first, *below = broken.split("\n")
    assert first == "broken"
    assert below
    assert all(line.startswith("  ") and line.isprintable() for line in below)
