"""What a call of the logger may be given: values, filters, exceptions, levels."""

import logging
from collections import OrderedDict
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase import RosbaseLogger, SystemClock
from rosbase.logger import make_logger
from rosbase.logger.record_text import fill_in
from rosbase.testing import ManualClock

LEVELS = {
    "debug": 10,
    "info": 20,
    "warn": 30,
    "warning": 30,
    "error": 40,
    "exception": 40,
    "critical": 50,
    "fatal": 50,
}


class Broken:
    """A value whose code raises when it is shown."""

    def __str__(self) -> str:
        raise ZeroDivisionError("no text")

    __repr__ = __str__


class Heard(logging.Handler):
    """A listener, which keeps what it is given."""

    def __init__(self) -> None:
        super().__init__(logging.DEBUG)
        self.records: list[logging.LogRecord] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.records.append(record)

    @property
    def texts(self) -> list[str]:
        return [record.getMessage() for record in self.records]


@pytest.fixture
def heard() -> Heard:
    return Heard()


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock()


@pytest.fixture
def logger(heard: Heard, clock: ManualClock, caplog: pytest.LogCaptureFixture) -> RosbaseLogger:
    caplog.set_level(logging.DEBUG)
    return RosbaseLogger("calls", clock, heard)


@pytest.mark.parametrize(
    ("message", "values", "line"),
    [
        ("x %d", (3,), "x 3"),
        ("%s of %5.1f", ("one", 2), "one of   2.0"),
        ("%(a)s and %(b)d", ({"a": "left", "b": 2},), "left and 2"),
        ("%s", ({"a": 1},), "{'a': 1}"),
        ("%s", ({},), "{}"),
        ("%s", ((1, 2),), "(1, 2)"),
        ("%s", ([1, 2],), "[1, 2]"),
        ("100 %", (), "100 %"),
        ("100 % done %d %s %(x)s", (), "100 % done %d %s %(x)s"),
        ("100 %% at %d", (5,), "100 % at 5"),
        ("%%", (), "%%"),
        ("%s", ("%d",), "%d"),
        (7, (), "7"),
        (ValueError("lens"), (), "lens"),
        (b"\xff", (), r"b'\xff'"),
        ("%r", ("a\nb",), r"'a\nb'"),
        ("%s", ("a\nb\x1b[2J",), r"a\nb\x1b[2J"),
        ("", (), ""),
    ],
)
def test_values_fill_the_message_as_in_logging(
    logger: RosbaseLogger, heard: Heard, message: Any, values: tuple[object, ...], line: str
) -> None:
    logger.info(message, *values)
    assert heard.texts == [line]


@pytest.mark.parametrize(
    ("message", "values", "why"),
    [
        ("x %d", ("three",), "x %d (cannot be formatted with 'three': %d format: "),
        ("x", (3,), "x (cannot be formatted with 3: not all arguments converted"),
        ("%s %s", (1,), "%s %s (cannot be formatted with 1: not enough arguments"),
        ("100 % of %s", ("it",), "100 % of %s (cannot be formatted with 'it': "),
        ("%(a)s", ({"b": 1},), "%(a)s (cannot be formatted with {'b': 1}: 'a')"),
        ("%(a)s", ("x",), "%(a)s (cannot be formatted with 'x': format requires a mapping)"),
        ("%", (1,), "% (cannot be formatted with 1: incomplete format)"),
        ("%y", (1,), "%y (cannot be formatted with 1: unsupported format character 'y'"),
        ("%s", (Broken(),), "%s (cannot be formatted with <Broken that cannot be shown: "),
        (Broken(), (), "<Broken that cannot be shown: ZeroDivisionError>"),
        ("%d", (float("nan"),), "%d (cannot be formatted with nan: "),
        ("%*d", (1,), "%*d (cannot be formatted with 1: not enough arguments"),
        ("%c", (-1,), "%c (cannot be formatted with -1: "),
    ],
)
def test_a_wrong_format_is_one_clear_line_and_raises_nothing(
    logger: RosbaseLogger,
    heard: Heard,
    caplog: pytest.LogCaptureFixture,
    capsys: pytest.CaptureFixture[str],
    message: Any,
    values: tuple[object, ...],
    why: str,
) -> None:
    logger.warning(message, *values)
    (line,) = heard.texts
    assert line.startswith(why)
    assert caplog.messages == [line]
    assert capsys.readouterr().err == ""


@given(st.text(), st.lists(st.one_of(st.integers(), st.text(), st.none(), st.floats())))
def test_filling_in_gives_what_python_gives_or_says_that_it_cannot(
    message: str, values: list[object]
) -> None:
    filled = fill_in(message, tuple(values))
    try:
        expected = message % tuple(values) if values else message
    except (TypeError, ValueError, OverflowError, MemoryError, KeyError):
        assert filled.startswith(f"{message} (cannot be formatted with ")
    else:
        assert filled == expected


@pytest.mark.parametrize("level", LEVELS)
def test_each_level_takes_values_and_filters(
    logger: RosbaseLogger, heard: Heard, level: str
) -> None:
    say: Callable[..., None] = getattr(logger, level)
    for number in range(3):
        say("each %d", number)
        say("once %d", number, once=True)
        say("skip %d", number, skip_first=True)
        say("seldom %d", number, throttle_duration_sec=60.0)
    assert heard.texts == ["each 0", "once 0", "seldom 0", "each 1", "skip 1", "each 2", "skip 2"]
    assert {record.levelno for record in heard.records} == {LEVELS[level]}


def test_two_calls_in_one_line_are_two_places(logger: RosbaseLogger, heard: Heard) -> None:
    exec("for _ in (1, 2): log.info('a', once=True); log.info('b', once=True)", {"log": logger})
    assert heard.texts == ["a", "b"]


def test_the_throttle_counts_from_the_last_line_and_needs_no_real_time(
    logger: RosbaseLogger, heard: Heard, clock: ManualClock
) -> None:
    for tenth in range(25):
        logger.info("%d", tenth, throttle_duration_sec=1.0)
        clock.date_ns += 3_600 * 10**9
        clock.advance(0.1)
    assert heard.texts == ["0", "10", "20"]


def test_filters_join_in_the_order_of_rclpy(
    logger: RosbaseLogger, heard: Heard, clock: ManualClock
) -> None:
    for second in range(6):
        logger.info("%d", second, throttle_duration_sec=2.0, skip_first=True, once=True)
        clock.advance(1.0)
    assert heard.texts == ["2"], "0 was skipped, 1 was throttled, and 2 was the one"


def test_a_call_below_the_level_does_not_count_for_its_filters(
    logger: RosbaseLogger, heard: Heard
) -> None:
    for level in ("WARN", "DEBUG", "DEBUG"):
        logger.set_level(level)
        logger.info("now", once=True)
    logger.set_level(0)
    assert heard.texts == ["now"]


@pytest.mark.parametrize("off", [{"once": False}, {"skip_first": False}])
@pytest.mark.parametrize("duration_s", [0, 0.0, None])
def test_a_filter_that_is_off_filters_nothing(
    logger: RosbaseLogger, heard: Heard, off: Any, duration_s: Any
) -> None:
    for _ in range(2):
        logger.info("x", throttle_duration_sec=duration_s, **off)
    assert heard.texts == ["x", "x"]


def test_reset_forgets_every_filter(logger: RosbaseLogger, heard: Heard) -> None:
    for _ in range(2):
        for _ in range(2):
            logger.info("once", once=True)
            logger.info("skip", skip_first=True)
            logger.info("seldom", throttle_duration_sec=9.0)
        logger.reset()
    assert heard.texts == ["once", "seldom", "skip"] * 2


@pytest.mark.parametrize("kind", ["rosbase", "rclpy"])
def test_a_throttle_takes_a_clock_of_rosbase_or_one_like_those_of_rclpy(
    logger: RosbaseLogger, heard: Heard, clock: ManualClock, kind: str
) -> None:
    seconds = iter(range(100))
    theirs = SimpleNamespace(now=lambda: SimpleNamespace(nanoseconds=next(seconds) * 10**9))
    source = clock if kind == "rosbase" else theirs
    for number in range(4):
        logger.info("%d", number, throttle_duration_sec=2.0, throttle_time_source_type=source)
        clock.date_ns += 10**9
    assert heard.texts == ["0", "2"]


@pytest.mark.parametrize(
    ("options", "error", "why"),
    [
        ({"throttle_time_source_type": SystemClock()}, TypeError, "throttle_duration_sec"),
        (
            {"throttle_time_source_type": "RCUTILS_STEADY_TIME", "throttle_duration_sec": 1.0},
            ValueError,
            "'RCUTILS_STEADY_TIME', not a clock",
        ),
        ({"onec": True}, TypeError, "onec"),
        ({"throttle": 1.0}, TypeError, "throttle"),
    ],
)
def test_options_that_mean_nothing_are_refused(
    logger: RosbaseLogger, options: Any, error: type[Exception], why: str
) -> None:
    with pytest.raises(error, match=why):
        logger.info("x", **options)


def test_exceptions_are_logged_with_their_traceback_wherever_they_come_from(
    logger: RosbaseLogger, heard: Heard
) -> None:
    try:
        raise OSError("gone")
    except OSError as caught:
        error, info = caught, (OSError, caught, caught.__traceback__)
        logger.exception("at %d", 1)
        logger.info("at %d", 2, exc_info=True)
    logger.fatal("at %d", 3, exc_info=error)
    logger.warn("at %d", 4, exc_info=info)
    logger.exception("at %d", 5, exc_info=False)
    logger.error("at %d", 6, exc_info=True)
    for number, text in enumerate(heard.texts, 1):
        first, *below = text.split("\n")
        assert first == f"at {number}"
        assert bool(below) == (number <= 4)
        assert all(line.startswith("  ") for line in below)
    assert sum("OSError: gone" in text for text in heard.texts) == 4


def test_a_traceback_that_cannot_be_shown_raises_nothing(
    logger: RosbaseLogger, heard: Heard
) -> None:
    class OddError(Exception):
        def __str__(self) -> str:
            raise ValueError("no")

    logger.error("broken", exc_info=OddError())
    assert heard.texts[0].startswith("broken\n  ")
    assert "OddError" in heard.texts[0]


def say_for(logger: RosbaseLogger, stacklevel: int) -> None:
    logger.info("x", stacklevel=stacklevel, once=True)


def test_stacklevel_says_whose_place_counts(
    logger: RosbaseLogger, heard: Heard, caplog: pytest.LogCaptureFixture
) -> None:
    for _ in range(2):
        say_for(logger, 1)
        say_for(logger, 2)
    here = "test_stacklevel_says_whose_place_counts"
    assert [record.funcName for record in heard.records] == ["say_for", here]
    assert [record.funcName for record in caplog.records] == ["say_for", here]


def test_extra_and_stack_info_are_those_of_logging(
    logger: RosbaseLogger, heard: Heard, caplog: pytest.LogCaptureFixture
) -> None:
    logger.info("x", extra={"joint": "knee"}, stack_info=True)
    (record,) = caplog.records
    assert vars(record)["joint"] == "knee"
    assert "in test_extra_and_stack_info" in (record.stack_info or "")
    assert "in test_extra_and_stack_info" in heard.texts[0]


@pytest.mark.parametrize("level", ["WARN", "warning", 30, logging.WARNING])
def test_the_level_can_be_set_and_asked_for(
    logger: RosbaseLogger, heard: Heard, level: str | int
) -> None:
    logger.set_level(level)
    assert logger.get_effective_level() == logger.level == 30
    assert [logger.is_enabled_for(name) for name in ("debug", "INFO", "warn", 40, "fatal")] == [
        False,
        False,
        True,
        True,
        True,
    ]
    logger.info("no")
    logger.warn("yes")
    logger.set_level(0)
    assert heard.texts == ["yes"]


def test_a_level_that_there_is_not_is_refused(logger: RosbaseLogger) -> None:
    with pytest.raises(ValueError, match="no log level is called 'loud': debug, info, warn"):
        logger.set_level("loud")


@pytest.mark.parametrize("level", [0, 3, 11, 2.5, True, None, "loud", "of the arm"])
def test_a_value_taken_for_the_level_of_a_message_is_refused(
    logger: RosbaseLogger, heard: Heard, level: Any
) -> None:
    calls: list[Callable[[], None]] = [
        lambda: logger.important("battery at %d percent", level),
        lambda: logger.log_once("battery at %d percent", level),
        lambda: logger.log_throttle("battery at %d percent", 5, level),
        # Refused again, although it is not due.
        lambda: logger.log_throttle("battery at %d percent", 5, level),
    ]
    for call in calls:
        with pytest.raises(ValueError, match="log level"):
            call()
    assert heard.texts == []


def test_a_message_may_have_a_level_that_the_program_has_named(
    logger: RosbaseLogger, heard: Heard
) -> None:
    logging.addLevelName(35, "NOTICE")
    logger.important("here", 35)
    logger.important("there", "notice")
    assert heard.texts == ["*** here ***", "*** there ***"]


def test_a_child_has_a_name_below_and_whoever_listens(logger: RosbaseLogger, heard: Heard) -> None:
    child = logger.get_child("leg").get_child("knee")
    child.info("bent %d", 3)
    (record,) = heard.records
    assert (child.name, record.name, record.getMessage()) == (
        "calls.leg.knee",
        "calls.leg.knee",
        "bent 3",
    )
    logger.set_level("ERROR")
    child.info("not heard")
    logger.set_level(0)
    assert len(heard.records) == 1


class Old:
    """A program's own logger, as they are: some methods, some names."""

    def __init__(self, name: str) -> None:
        self.lines: list[str] = []

    def info(self, message: str, *values: object) -> None:
        self.lines.append(f"info {message % values}")

    def warn(self, message: str) -> None:
        self.lines.append(f"warn {message}")

    def fatal(self, message: str) -> None:
        self.lines.append(f"fatal {message}")

    def set_level(self, level: str) -> str:
        return f"set to {level}"


def test_a_custom_logger_gets_the_methods_that_it_lacks_and_keeps_those_that_it_has(
    heard: Heard,
) -> None:
    logger: Any = make_logger("old", Old, None, heard)
    for number in range(2):
        logger.info("x %d", number, once=True)
        logger.info("y %d", number, skip_first=True)
        logger.warning("hot", throttle_duration_sec=9.0)
    logger.warn("warm")
    logger.critical("end")
    logger.fatal("very end")
    assert logger.set_level("LOUD") == "set to LOUD"
    assert logger.lines == [
        "info x 0",
        "warn hot",
        "info y 1",
        "warn warm",
        "fatal end",
        "fatal very end",
    ]
    assert [record.levelno for record in heard.records] == [20, 30, 20, 30, 50, 50]


def test_a_custom_logger_without_a_level_gets_one() -> None:
    class Plain:
        def __init__(self, name: str) -> None:
            self.lines: list[str] = []

        def info(self, message: str) -> None:
            self.lines.append(message)

    logger: Any = make_logger("plain", Plain)
    logger.set_level("WARN")
    logger.info("no")
    logger.set_level("INFO")
    logger.info("yes")
    assert logger.lines == ["yes"]
    assert logger.get_effective_level() == 20


def test_call_sites_do_not_pile_up(logger: RosbaseLogger) -> None:
    for number in range(1200):
        code = compile("logger.debug('x', once=True)", f"cell {number}", "exec")
        exec(code, {"logger": logger})
    assert len(logger._filters._logged) <= 1000


def test_a_mapping_need_not_be_a_dict() -> None:
    assert fill_in("%(a)s", (OrderedDict(a=1),)) == "1"
