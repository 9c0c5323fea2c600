"""The lines of the log: their format, and their colours."""

import io
import logging
import os
import pty
import re
import subprocess
import sys
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase import RosbaseLogger, RosFormatter
from rosbase.logger import Console, use_console
from rosbase.logger.formatter import DEFAULT_FORMAT


def record(message: object = "ready", level: int = logging.INFO) -> logging.LogRecord:
    made = logging.LogRecord("rosbase.left", level, "/opt/walk.py", 7, message, (), None, "step")
    made.created = 1_700_000_000.25
    return made


def test_the_usual_format_is_that_of_rcutils() -> None:
    assert DEFAULT_FORMAT == "[{severity}] [{time}] [{name}]: {message}"
    assert RosFormatter().format(record()) == "[INFO] [1700000000.250000000] [left]: ready"


@pytest.mark.parametrize(
    ("template", "line"),
    [
        ("{severity}", "INFO"),
        ("{name}", "left"),
        ("{message}", "ready"),
        ("{time}", "1700000000.250000000"),
        ("{time_as_nanoseconds}", "1700000000250000000"),
        ("{function_name}", "step"),
        ("{file_name}", "/opt/walk.py"),
        ("{line_number}", "7"),
        ("{message} ({file_name}:{line_number})", "ready (/opt/walk.py:7)"),
        ("{message}{message}", "readyready"),
        ("{{name}}", "{left}"),
        ("{foo} {Name} {name", "{foo} {Name} {name"),
        ("{} { } %s {0}", "{} { } %s {0}"),
        ("nothing", "nothing"),
        (r"{name}\t{message}\x41", "left\tready\\x41"),
    ],
)
def test_each_token_of_rcutils_is_filled_in_and_nothing_else(template: str, line: str) -> None:
    assert RosFormatter(template).format(record()) == line


def test_what_is_important_is_bold_where_there_are_colours() -> None:
    lines: list[str] = []
    use_console(Console(lines.append, has_colour=True))
    logging.getLogger("rosbase").propagate = False
    RosbaseLogger("x").important("goal")
    RosbaseLogger("x").warning("other")
    assert lines[0].startswith("\x1b[0m\x1b[1m[INFO]")
    assert lines[0].endswith("*** goal ***\x1b[0m\n")
    assert lines[1].startswith("\x1b[33m[WARN]")


def test_the_date_is_local_with_milliseconds() -> None:
    local = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(1_700_000_000))
    assert RosFormatter("{date_time_with_ms}").format(record()) == f"{local}.250"


@given(st.text())
def test_any_format_is_taken(template: str) -> None:
    RosFormatter(template).format(record())


@pytest.mark.parametrize(
    ("level", "name"),
    [
        (1, "DEBUG"),
        (10, "DEBUG"),
        (20, "INFO"),
        (25, "INFO"),
        (30, "WARN"),
        (40, "ERROR"),
        (50, "FATAL"),
        (400, "FATAL"),
    ],
)
def test_severities_have_the_names_of_ros(level: int, name: str) -> None:
    assert RosFormatter("{severity}").format(record(level=level)) == name


@given(st.text())
def test_no_message_makes_two_records_of_one(message: str) -> None:
    first, *below = RosFormatter("{name}: {message}").format(record(message)).split("\n")
    assert first.startswith("left: ")
    assert first.isprintable()
    assert all(line.startswith("  ") and line.isprintable() for line in below)


def test_a_traceback_stands_indented_below_the_whole_line() -> None:
    made = record("broken")
    made.exc_text = "  Traceback\n    in step\n  OSError: gone\n[INFO] [boss]: forged"
    made.stack_info = "Stack:\n  in walk"
    assert RosFormatter("{message} at {line_number}").format(made) == (
        "broken at 7\n"
        "    Traceback\n      in step\n    OSError: gone\n  [INFO] [boss]: forged\n"
        "  Stack:\n    in walk"
    )


@pytest.mark.parametrize(
    ("level", "colour"), [(10, "32"), (20, "0"), (30, "33"), (40, "31"), (50, "31")]
)
def test_colours_are_those_of_rcutils(level: int, colour: str) -> None:
    line = RosFormatter("{message}", has_colour=True).format(record(level=level))
    assert line == f"\x1b[{colour}mready\x1b[0m"


def test_the_format_of_the_environment_counts_for_whoever_gives_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("RCUTILS_CONSOLE_OUTPUT_FORMAT", "{name} says {message}")
    assert RosFormatter().format(record()) == "left says ready"
    assert RosFormatter("{message}").format(record()) == "ready"
    monkeypatch.setenv("RCUTILS_CONSOLE_OUTPUT_FORMAT", "")
    assert RosFormatter().format(record()).startswith("[INFO] [")


SAYING = "from rosbase import RosbaseLogger; RosbaseLogger('boss').warning('hot')"


def said_on_a_terminal(**variables: str) -> str:
    """What a program writes to stderr if that is a terminal."""
    own_end, far_end = pty.openpty()
    try:
        subprocess.run(
            [sys.executable, "-c", SAYING],
            stderr=far_end,
            env={**os.environ, **variables},
            timeout=30,
            check=True,
        )
        return os.read(own_end, 4096).decode()
    finally:
        os.close(own_end)
        os.close(far_end)


def said_through_a_pipe(**variables: str) -> tuple[str, str]:
    done = subprocess.run(
        [sys.executable, "-c", SAYING],
        capture_output=True,
        text=True,
        env={**os.environ, **variables},
        timeout=30,
        check=True,
    )
    return done.stdout, done.stderr


@pytest.mark.parametrize(
    ("variables", "has_colour"),
    [
        ({}, True),
        ({"NO_COLOR": "1"}, False),
        ({"NO_COLOR": ""}, True),
        ({"RCUTILS_COLORIZED_OUTPUT": "0"}, False),
        ({"RCUTILS_COLORIZED_OUTPUT": "1", "NO_COLOR": "1"}, True),
    ],
)
def test_a_terminal_has_colours_unless_the_environment_says_no(
    variables: dict[str, str], has_colour: bool
) -> None:
    said = said_on_a_terminal(**variables)
    line = re.compile(r"\[WARN\] \[\d+\.\d{9}\] \[boss\]: hot")
    assert line.search(said)
    assert said.startswith("\x1b[33m[WARN]") == has_colour
    assert ("\x1b" in said) == has_colour


def test_a_pipe_has_colours_only_if_they_are_asked_for() -> None:
    assert "\x1b" not in said_through_a_pipe()[1]
    assert said_through_a_pipe(RCUTILS_COLORIZED_OUTPUT="1")[1].startswith("\x1b[33m[WARN]")


def test_stdout_gets_the_log_if_rcutils_is_told_so() -> None:
    out, err = said_through_a_pipe(RCUTILS_LOGGING_USE_STDOUT="1")
    assert "[boss]: hot" in out
    assert err == ""


def test_a_console_takes_lines_elsewhere_and_a_stream_that_is_closed_raises_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # The handlers of pytest count as an application's.
    monkeypatch.setattr(logging.getLogger("rosbase"), "propagate", False)
    lines: list[str] = []
    use_console(Console(lines.append))
    RosbaseLogger("boss").info("here")
    assert re.fullmatch(r"\[INFO\] \[\d+\.\d{9}\] \[boss\]: here\n", lines[0])
    use_console(None)
    for stream in (None, io.StringIO()):
        if stream is not None:
            stream.close()
        monkeypatch.setattr(sys, "stderr", stream)
        RosbaseLogger("boss").info("nobody hears")
    assert len(lines) == 1
