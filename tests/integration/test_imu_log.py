"""The log of the command: on a terminal, by level and format, and beside libraries."""

import os
import re
import subprocess
import sys

import pytest

from support.command import ROSBASE, run_rosbase
from support.log_lines import without_times
from support.serial_port import PluggablePort
from support.terminal import on_terminal

ABSENT = ("imu", "-p", "device_path:=/dev/nope", "--duration", "0.3")
FAILED = "[ERROR] [lifecycle_manager]: configure failed, now unconfigured: /dev/nope is not there"
SAID_LAST = "rosbase: the reader did not become active."
CLEAR = re.compile(rb"\r(?:\x1b\[\d+A)?\x1b\[J")
COLOURS = {"NO_COLOR": "", "TERM": "xterm"}


def test_without_a_status_line_nothing_is_cleared_on_a_terminal(port: PluggablePort) -> None:
    # As under the `emulate_tty` of launch.
    port.plug()
    options = ("--managed", "-p", f"device_path:={port.path}", "-p", "autostart:=activate")
    with on_terminal(ROSBASE, "imu", *options, environment=COLOURS) as terminal:
        terminal.waits_for("opened")
        port.unplug()
        terminal.waits_for("was lost")
        shown = terminal.end()
    assert shown.startswith(b"\x1b[0m[INFO] [")
    assert not CLEAR.search(shown)


def test_a_record_takes_the_place_of_the_status_line_and_clears_nothing_before_there_is_one(
    port: PluggablePort,
) -> None:
    port.plug()
    command = (ROSBASE, "imu", "-p", f"device_path:={port.path}")
    with on_terminal(*command, environment=COLOURS) as terminal:
        terminal.waits_for("opened")
        terminal.waits_for(" Hz")
        before = terminal.shown
        port.unplug()
        terminal.waits_for("was lost")
        shown = terminal.end()
    assert b"opened" in CLEAR.split(before)[0], "the first record stands at the very beginning"
    lost = next(line for line in shown.split(b"\n") if b"was lost" in line)
    record = rb"\x1b\[J\x1b\[33m\[WARN\] \[\d+\.\d{9}\] \[lifecycle_manager\]: "
    assert re.search(record, lost)
    assert lost.rstrip(b"\r").endswith(b"\x1b[0m")


def test_a_terminal_without_colours_has_none() -> None:
    with on_terminal(ROSBASE, *ABSENT, environment={**COLOURS, "NO_COLOR": "1"}) as terminal:
        terminal.waits_for(SAID_LAST)
        shown = terminal.end()
    assert b"configure failed" in shown
    assert b"\x1b[31m" not in shown
    assert b"\x1b[0m" not in shown


@pytest.mark.parametrize(
    ("levels", "is_said"),
    [
        ([], True),
        (["debug"], True),
        (["ERROR"], True),
        (["fatal"], False),
        (["critical"], False),
        (["lifecycle_manager:=fatal"], False),
        (["other:=fatal"], True),
        (["fatal", "lifecycle_manager:=info"], True),
    ],
)
def test_the_log_level_is_that_of_all_loggers_or_of_one(levels: list[str], is_said: bool) -> None:
    options = [word for level in levels for word in ("--log-level", level)]
    done = run_rosbase(*ABSENT, *options)
    assert done.returncode == 1
    *log, last = without_times(done.stderr).splitlines()
    assert last.startswith(SAID_LAST)
    assert [line.startswith(FAILED) for line in log] == [True] * is_said


@pytest.mark.parametrize("level", ["loud", "", "x:=", "x:=loud"])
def test_a_level_that_there_is_not_is_one_line(level: str) -> None:
    done = run_rosbase("imu", "--log-level", level)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "no log level is called" in done.stderr


def run_after(code: str, **variables: str) -> "subprocess.CompletedProcess[str]":
    """Runs the command in a process that has run this code."""
    return subprocess.run(
        [
            sys.executable,
            "-c",
            f"import logging, sys\n{code}\nfrom rosbase.cli import main; sys.exit(main())",
            *ABSENT,
        ],
        capture_output=True,
        text=True,
        env={**os.environ, **variables},
        timeout=30,
        check=False,
    )


@pytest.mark.parametrize(
    "code",
    [
        "logging.info('lib')",
        "logging.basicConfig(level='CRITICAL', format='%(message)s')",
        "logging.getLogger().addHandler(logging.FileHandler('/dev/null'))",
        "import logging.config; logging.config.dictConfig({'version': 1})",
    ],
)
def test_the_command_is_the_application_whatever_a_plugin_does(code: str) -> None:
    done = run_after(code)
    assert done.returncode == 1
    assert without_times(done.stderr).count(FAILED) == 1
    assert done.stderr.count("\n") == 2


def test_the_format_is_that_of_the_environment() -> None:
    done = run_after("", RCUTILS_CONSOLE_OUTPUT_FORMAT="{name} {severity} {message}")
    assert done.stderr.startswith("lifecycle_manager ERROR configure failed, now unconfigured")
