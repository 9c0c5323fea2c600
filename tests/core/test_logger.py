import copy
import logging
import math
import subprocess
import sys
from typing import Any

import pytest

from rosbase import BaseHandlers, BaseManager, BaseNode
from rosbase.logger import RosbaseLogger, make_logger
from rosbase.testing import ManualClock, virtual_backend
from support.log_lines import without_times
from support.roles import Brain, Camera


@pytest.fixture
def records(caplog: pytest.LogCaptureFixture) -> pytest.LogCaptureFixture:
    logging.getLogger("rosbase").propagate = True
    caplog.set_level(logging.DEBUG, logger="rosbase")
    return caplog


def test_once_means_once_until_reset(records: pytest.LogCaptureFixture) -> None:
    logger = RosbaseLogger("node")
    for _ in range(3):
        logger.info("hello", once=True)
        logger.log_once("hello", "warning")
    assert [r.levelname for r in records.records] == ["INFO", "WARNING"]
    logger.reset()
    logger.info("hello", once=True)
    assert len(records.records) == 3


def test_the_throttle_runs_on_the_monotonic_clock(records: pytest.LogCaptureFixture) -> None:
    clock = ManualClock()
    logger = RosbaseLogger("node", clock)
    for _ in range(10):
        logger.log_throttle("again", 2.0)
        clock.date_ns += 3_600 * 10**9
        clock.advance(0.5)
    assert len(records.records) == 3


def test_messages_keep_their_percent_signs(records: pytest.LogCaptureFixture) -> None:
    RosbaseLogger("node").important("100 % done")
    assert records.messages == ["*** 100 % done ***"]


def test_an_unknown_level_is_refused() -> None:
    with pytest.raises(ValueError, match="loud"):
        RosbaseLogger("node").important("x", "loud")


LEVELS = ["debug", "info", "warning", "error", "critical"]


@pytest.mark.parametrize("level", LEVELS)
def test_each_level_has_a_method_that_can_say_it_once(
    records: pytest.LogCaptureFixture, level: str
) -> None:
    logger = RosbaseLogger("node")
    for _ in range(2):
        getattr(logger, level)("each time")
        getattr(logger, level)("one time", once=True)
    assert records.messages == ["each time", "one time", "each time"]
    assert {(r.levelname, r.name) for r in records.records} == {(level.upper(), "rosbase.node")}


def test_what_is_said_once_or_is_important_is_info_unless_a_level_is_named(
    records: pytest.LogCaptureFixture,
) -> None:
    logger = RosbaseLogger("node")
    for say in (
        logger.log_once,
        logger.important,
        lambda *a: logger.log_throttle(a[0], 1.0, *a[1:]),
    ):
        say("a")
        say("b", "ERROR")
    assert [r.levelname for r in records.records] == ["INFO", "ERROR"] * 3


def test_each_message_is_throttled_on_its_own_and_reset_forgets_the_throttle(
    records: pytest.LogCaptureFixture,
) -> None:
    logger = RosbaseLogger("node", ManualClock())
    for message in ("a", "b", "a"):
        logger.log_throttle(message, 5.0)
    logger.reset()
    logger.log_throttle("a", 5.0)
    assert records.messages == ["a", "b", "a"]


def test_levels_are_throttled_on_their_own_and_a_disabled_one_uses_up_nothing(
    records: pytest.LogCaptureFixture,
) -> None:
    logger = RosbaseLogger("throttled", ManualClock())
    logger.set_level("INFO")
    for level in ("DEBUG", "ERROR", "WARNING", "ERROR"):
        logger.log_throttle("motor", 10.0, level)
    assert [record.levelname for record in records.records] == ["ERROR", "WARNING"]
    logger.set_level("DEBUG")
    logger.log_throttle("motor", 10.0, "DEBUG")
    assert records.records[-1].levelname == "DEBUG"
    logger.set_level(0)


def test_a_throttle_takes_numbers_and_once_for_all_is_one(
    records: pytest.LogCaptureFixture,
) -> None:
    clock = ManualClock()
    logger = RosbaseLogger("node", clock)
    for _ in range(3):
        logger.log_throttle("motor", math.inf)
        clock.advance(1e9)
    assert records.messages == ["motor"]
    says: list[Any] = [logger.log_throttle, logger.due]
    for say in says:
        with pytest.raises(TypeError, match="seconds is a number, not '5'"):
            say("other", "5")
        with pytest.raises(ValueError, match="not NaN"):
            say("other", math.nan)
    assert records.messages == ["motor"]


class OwnLogger:
    """A program's own: what it is made with, what it writes, and what only it can do."""

    def __init__(self, name: str, *others: Any) -> None:
        self.made_with = (name, *others)
        self.lines: list[str] = []

    def info(self, message: str, color: str = "") -> None:
        self.lines.append(f"info {message}{color}")

    def error(self, message: str) -> None:
        self.lines.append(f"error {message}")

    def important(self, message: str) -> None:
        self.lines.append(f"!!! {message}")

    def celebrate(self) -> str:
        return "hurrah"


def own_manager() -> BaseManager:
    return BaseManager(
        "boss",
        {"camera": Camera},
        {"brain": Brain},
        BaseHandlers,
        custom_logger=OwnLogger,
        backend=virtual_backend(),
    )


def test_a_custom_logger_is_made_with_the_name_and_serves_everything_attached() -> None:
    manager = own_manager()
    assert manager.handlers is not None
    logger: Any = manager.logger
    for component in (manager.nodes["camera"], manager.agents["brain"], manager.handlers):
        assert component.logger is logger
        component.logger.info("here")
    assert logger.made_with == ("boss",)
    assert logger.lines == ["info here"] * 3
    manager.destroy_node()


def test_a_custom_logger_keeps_what_it_can_do_and_is_given_what_it_cannot() -> None:
    manager = own_manager()
    logger: Any = manager.logger
    assert logger.celebrate() == "hurrah"
    logger.info("ready", color=" in green")
    logger.important("goal")
    for _ in range(2):
        logger.info("once", once=True)
        logger.log_once("once", "ERROR")
        logger.log_throttle("often", 1.0)
    assert logger.lines == [
        "info ready in green",
        "!!! goal",
        "info once",
        "error once",
        "info often",
    ]
    manager.destroy_node()


PROGRAM = """
from rosbase import BaseManager, BaseNode
manager = BaseManager("boss", {"camera": BaseNode})
for level in ("debug", "info", "warning", "error", "critical"):
    getattr(manager.nodes["camera"].logger, level)(f"said as {level}")
manager.destroy_node()
"""


@pytest.mark.parametrize(
    ("setup", "expected"),
    [
        (
            "",
            "[INFO] [boss.camera]: said as info\n[WARN] [boss.camera]: said as warning\n"
            "[ERROR] [boss.camera]: said as error\n[FATAL] [boss.camera]: said as critical\n",
        ),
        (
            "import logging; logging.basicConfig(format='%(name)s %(message)s', level='ERROR')",
            "rosbase.boss.camera said as error\nrosbase.boss.camera said as critical\n",
        ),
    ],
    ids=["nothing is configured", "logging is configured"],
)
def test_info_and_worse_goes_to_stderr_unless_the_program_has_set_up_logging(
    setup: str, expected: str
) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", setup + PROGRAM],
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert (done.returncode, done.stdout, without_times(done.stderr)) == (0, "", expected)


def test_a_custom_logger_of_our_own_kind_throttles_on_the_clock_of_its_manager() -> None:
    class Mine(RosbaseLogger):
        pass

    clock = ManualClock()
    logger = make_logger("x", Mine, clock)
    due = []
    for _ in range(100):
        due.append(logger.due("key", 1.0))
        clock.advance(0.1)
    assert sum(due) == 10


def test_messages_that_are_throttled_and_never_repeated_do_not_pile_up() -> None:
    clock = ManualClock()
    logger = RosbaseLogger("x", clock)
    for number in range(5000):
        logger.log_throttle(f"distance {number}", 0.001)
        clock.advance(0.01)
    assert len(logger._next_ns) <= 1000


def test_a_custom_logger_can_be_copied() -> None:
    class Plain:
        def __init__(self, name: str) -> None:
            self.name = name

    assert copy.copy(make_logger("x", Plain)).name == "x"


class Listener(logging.Handler):
    """A backend's, which keeps what it is given."""

    def __init__(self, level: str = "INFO") -> None:
        super().__init__(level)
        self.records: list[logging.LogRecord] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.records.append(record)

    @property
    def said(self) -> list[tuple[str, str]]:
        return [(record.levelname, record.getMessage()) for record in self.records]


def test_a_backend_may_listen_to_its_manager_and_to_a_lone_node(
    records: pytest.LogCaptureFixture,
) -> None:
    for own in (None, OwnLogger):
        backend = virtual_backend()
        backend.log_handler = listener = Listener()
        BaseManager("boss", custom_logger=own, backend=backend).logger.info("manager")
        BaseNode(node_name="eye", custom_logger=own, backend=backend).logger.info("node")
        assert [(r.name, r.getMessage()) for r in listener.records] == [
            ("boss", "manager"),
            ("eye", "node"),
        ]


def test_who_listens_is_given_the_place_and_the_traceback(
    records: pytest.LogCaptureFixture,
) -> None:
    listener = Listener()
    logger = RosbaseLogger("node", None, listener)
    try:
        raise OSError("gone")
    except OSError as error:
        logger.error("100 % lost", exc_info=error)
        logger.error("100 % lost", exc_info=True)
    for record, written in zip(listener.records, records.records, strict=True):
        assert record.getMessage().startswith("100 % lost\n  Traceback (most recent call last)")
        assert record.getMessage().endswith("OSError: gone")
        assert (record.pathname, record.lineno, record.funcName) == (
            written.pathname,
            written.lineno,
            written.funcName,
        )


def test_what_the_application_does_not_let_through_is_not_heard(
    records: pytest.LogCaptureFixture,
) -> None:
    listener = Listener("DEBUG")
    logger = RosbaseLogger("node", None, listener)
    logging.getLogger("rosbase").setLevel("WARNING")
    logger.info("no")
    logger.log_once("yes", "ERROR")
    logger.log_once("yes", "ERROR")
    assert listener.said == [("ERROR", "yes")]


LISTENED = """
import logging
import math
from rosbase.logger import make_logger
class Listener(logging.Handler):
    def emit(self, record):
        print(record.levelname, record.getMessage())
logger = make_logger("boss", None, None, Listener({level!r}))
logger.debug("quiet")
logger.info("loud")
"""


@pytest.mark.parametrize(
    ("level", "heard", "console"),
    [
        ("DEBUG", "DEBUG quiet\nINFO loud\n", "[DEBUG] [boss]: quiet\n[INFO] [boss]: loud\n"),
        ("INFO", "INFO loud\n", "[INFO] [boss]: loud\n"),
        ("WARNING", "", ""),
    ],
)
def test_who_listens_silences_nothing_and_has_the_level_where_nobody_set_up_logging(
    level: str, heard: str, console: str
) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", LISTENED.format(level=level)],
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert (done.returncode, done.stdout, without_times(done.stderr)) == (0, heard, console)


def test_what_only_a_custom_logger_fills_in_or_says_once_is_heard_as_it_wrote_it() -> None:
    class Theirs(OwnLogger):
        def warning(self, message: str, *values: object) -> None:
            self.lines.append(message % values)

        def log_once(self, message: str, level: str = "INFO") -> None:
            self.lines.append(message)

    listener = Listener()
    logger: Any = make_logger("x", Theirs, None, listener)
    logger.warning("%d of %s", 3, "them")
    logger.info("50 %", " in green")
    logger.debug("below its level")
    logger.important("goal")
    for _ in range(2):
        logger.log_once("once", "ERROR")
        logger.log_once("again", level="WARNING")
    assert listener.said == [
        ("WARNING", "3 of them"),
        ("INFO", "50 %"),
        ("INFO", "goal"),
        ("ERROR", "once"),
        ("WARNING", "again"),
    ]
