"""The log as a ROS log: format, names, file and flags, compared with rclpy's own."""

import logging
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import rclpy
from hypothesis import given, settings
from hypothesis import strategies as st

from rosbase import RosbaseLogger, RosFormatter
from rosbase_ros2.log_file import LogFile
from rosbase_ros2.starting import is_enabled
from support.command import ROSBASE
from support.log_lines import without_times

THEIRS = """
import sys
import rclpy
rclpy.init(args=sys.argv)
logger = rclpy.create_node("walker").get_logger()
logger.debug("looking")
logger.info("100 % ready")
logger.warning("hot")
logger.error("lost")
logger.fatal("end")
logger.get_child("leg").info("bent")
rclpy.shutdown()
"""

OURS = """
import logging
logging.info("a library speaks")
from rosbase import BaseNode
node = BaseNode(backend="ros2", node_name="walker")
logger = node.logger
logger.debug("looking")
logger.info("100 % ready")
logger.warning("hot")
logger.error("lost")
logger.fatal("end")
logger.get_child("leg").info("bent")
node.destroy_node()
"""


class Run:
    """A program that has ended: what it wrote, and what is in its log file."""

    def __init__(self, folder: Path, source: str, *arguments: str, **variables: str) -> None:
        program, logs = folder / "program.py", folder / "logs"
        program.write_text(source)
        before = set(logs.iterdir()) if logs.exists() else set()
        done = subprocess.run(
            [sys.executable, str(program), *arguments],
            capture_output=True,
            env={**os.environ, "ROS_LOG_DIR": str(logs), **variables},
            timeout=40,
            check=False,
        )
        assert (done.returncode, done.stdout) == (0, b""), done.stderr
        self.console = done.stderr.decode()
        files = set(logs.iterdir()) - before if logs.exists() else set()
        self.files = [file.read_text() for file in files]


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["-r", "__node:=left", "-r", "__ns:=/robot"],
        ["-r", "__ns:=/a/b"],
        ["--log-level", "warn"],
        ["--log-level", "walker:=error"],
        ["--log-level", "WALKER:=error", "--log-level", "other:=debug"],
        ["--disable-stdout-logs"],
        ["--disable-stdout-logs", "--enable-stdout-logs"],
        ["--disable-rosout-logs"],
        ["--disable-external-lib-logs"],
        ["--disable-external-lib-logs", "--disable-stdout-logs"],
        ["--log-file-name", "mine"],
    ],
    ids=" ".join,
)
def test_console_and_file_have_the_lines_that_a_node_of_rclpy_has(
    tmp_path: Path, arguments: list[str]
) -> None:
    theirs = Run(tmp_path, THEIRS, "--ros-args", *arguments)
    ours = Run(tmp_path, OURS, "--ros-args", *arguments)
    assert without_times(ours.console) == without_times(theirs.console)
    assert [without_times(text) for text in ours.files] == [
        without_times(text) for text in theirs.files
    ]
    if ours.files and ours.console:
        assert ours.files == [ours.console], "with the same times"


def test_each_line_is_in_the_file_when_it_is_logged_also_after_the_end(tmp_path: Path) -> None:
    source = OURS + 'logger.info("late")\nimport os; os.kill(os.getpid(), 9)'
    with pytest.raises(AssertionError):
        Run(tmp_path, source)
    (file,) = (tmp_path / "logs").iterdir()
    assert without_times(file.read_text()).endswith("[INFO] [walker]: late\n")


@pytest.mark.parametrize(
    "template",
    [
        "{severity}|{name}|{message}|{function_name}|{file_name}|{line_number}",
        "{date_time_with_ms}",
        "[{severity}] {{name}} {foo} {} {name",
        r"a\tb\nc\a\b\r{message}\n\n\t",
        "{message} {message}{severity}",
        "plain",
    ],
)
def test_the_format_means_what_it_means_to_rcutils(tmp_path: Path, template: str) -> None:
    wanted = "{time_as_nanoseconds} {time} " + template
    for _ in range(20):
        theirs = Run(tmp_path, THEIRS, RCUTILS_CONSOLE_OUTPUT_FORMAT=wanted).console
        starts = list(re.finditer(r"(?m)^(\d{19}) \d{10}\.\d{9} ", theirs))
        # rcutils drops leading zeros of the milliseconds: it writes 9.87 ms as .987.
        if all(found[1][10] != "0" for found in starts):
            break
    formatter = RosFormatter(wanted)
    program, levels = tmp_path / "program.py", (20, 30, 40, 50, 20)
    source = THEIRS.splitlines()
    expected = []
    assert len(starts) == len(levels)
    for found, level, text in zip(
        starts, levels, ("100 % ready", "hot", "lost", "end", "bent"), strict=True
    ):
        line = next(n for n, code in enumerate(source, 1) if f'"{text}"' in code)
        name = "walker.leg" if text == "bent" else "walker"
        record = logging.LogRecord(name, level, str(program), line, text, (), None, "<module>")
        record.created = int(found[1]) / 1e9
        expected.append(formatter.format(record) + "\n")
    (ours, our_times), (text, times) = _timeless("".join(expected)), _timeless(theirs)
    assert ours == text
    # Records keep their time as a float, which is good for a microsecond.
    assert all(abs(one - other) < 1_000 for one, other in zip(our_times, times, strict=True))


def _timeless(text: str) -> tuple[str, list[int]]:
    """Return the text without the two times of each line, and these in nanoseconds."""
    times = re.compile(r"(?m)^(\d{19}) (\d{10})\.(\d{9}) ")
    found = [int(part) for m in times.finditer(text) for part in (m[1], m[2] + m[3])]
    return times.sub("", text), found


def test_colours_are_those_of_rcutils(tmp_path: Path) -> None:
    theirs, ours = (
        Run(
            tmp_path,
            source,
            RCUTILS_COLORIZED_OUTPUT="1",
            RCUTILS_CONSOLE_OUTPUT_FORMAT="{severity} {message}",
        )
        for source in (THEIRS, OURS)
    )
    assert ours.console == theirs.console
    assert "\x1b[33mWARN hot\x1b[0m\n" in ours.console
    assert all("\x1b" not in text for text in ours.files)


class Ours(logging.Handler):
    """Counts what it is given."""

    count = 0

    def emit(self, record: logging.LogRecord) -> None:
        self.count += 1


OPTIONS: list[dict[str, Any]] = [
    {},
    {"once": True},
    {"skip_first": True},
    {"throttle_duration_sec": 1000.0},
    {"once": True, "skip_first": True},
    {"once": True, "throttle_duration_sec": 1000.0},
    {"skip_first": True, "throttle_duration_sec": 1000.0},
    {"once": True, "skip_first": True, "throttle_duration_sec": 1000.0},
    {"once": False, "skip_first": False, "throttle_duration_sec": 0.0},
]
SITES = [
    # A place of its own for each.
    eval(
        compile("lambda logger: logger.info('x', **options)", f"/site {number}", "eval"),
        {"options": options},
    )
    for number, options in enumerate(OPTIONS)
]


@settings(max_examples=40)
@given(st.lists(st.integers(0, len(OPTIONS) - 1), max_size=30))
def test_filters_let_through_what_those_of_rclpy_do(calls: list[int]) -> None:
    theirs: Any = rclpy.logging.get_logger("quiet")
    theirs.contexts.clear()
    heard = Ours()
    ours = RosbaseLogger("quiet", None, heard, has_console=False)
    ours.set_level("INFO")
    for index in calls:
        before = heard.count
        SITES[index](ours)
        assert (heard.count > before) == SITES[index](theirs), OPTIONS[index]


@pytest.mark.parametrize(
    ("arguments", "enabled"),
    [
        ([], True),
        (["--disable-stdout-logs"], False),
        (["--disable-stdout-logs", "--enable-stdout-logs"], True),
        (["--enable-stdout-logs", "--disable-stdout-logs"], False),
        (["--disable-rosout-logs"], True),
    ],
)
def test_the_last_flag_counts(arguments: list[str], enabled: bool) -> None:
    assert is_enabled("stdout-logs", arguments) == enabled


def test_a_log_file_that_is_gone_or_full_raises_nothing(tmp_path: Path) -> None:
    record = logging.LogRecord("x", 20, "f", 1, "\ud800 text", (), None)
    for path in (tmp_path / "gone", tmp_path, Path("/dev/full")):
        LogFile(path).write(record)
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "there").touch()
    LogFile(tmp_path / "there").write(record)
    assert "text" in (tmp_path / "there").read_text()


def test_an_application_with_handlers_of_its_own_has_the_file_too(tmp_path: Path) -> None:
    source = OURS.replace(
        'logging.info("a library speaks")',
        'logging.basicConfig(format="app %(message)s", level="INFO")',
    )
    ours = Run(tmp_path, source)
    assert ours.console == "app 100 % ready\napp hot\napp lost\napp end\napp bent\n"
    assert without_times(ours.files[0]).startswith("[INFO] [walker]: 100 % ready\n[WARN]")


ABSENT = ("-p", "device_path:=/dev/nope", "--duration", "0.5")
NOTHING = "rosbase: nothing was published. `rosbase doctor`, with the same -p, says what to do\n"
FAILED = "configure failed, now unconfigured: /dev/nope is not there"


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ([], "[ERROR] [lifecycle_manager]: "),
        (["-r", "__node:=left", "-r", "__ns:=/robot"], "[ERROR] [robot.left]: "),
        (["--log-level", "fatal"], ""),
        (["--log-level", "lifecycle_manager:=fatal"], ""),
        (["--disable-stdout-logs"], ""),
    ],
)
def test_the_command_heeds_the_arguments_of_ros_for_the_log(
    tmp_path: Path, arguments: list[str], line: str
) -> None:
    ended = subprocess.run(
        [ROSBASE, "imu", "--backend", "ros2", *ABSENT, "--ros-args", *arguments],
        capture_output=True,
        text=True,
        env={**os.environ, "ROS_LOG_DIR": str(tmp_path)},
        timeout=40,
        check=False,
    )
    assert ended.returncode == 1
    log = ended.stderr.removesuffix(NOTHING)
    assert without_times(log).partition(FAILED)[0] == line
    (file,) = tmp_path.iterdir()
    is_quiet = "--disable-stdout-logs" in arguments
    assert (FAILED in file.read_text()) == (bool(line) or is_quiet)
    assert is_quiet or file.read_text() == log


def test_the_option_of_the_command_counts_on_ros_too(tmp_path: Path) -> None:
    ended = subprocess.run(
        [ROSBASE, "imu", "--backend", "ros2", *ABSENT, "--log-level", "fatal"],
        capture_output=True,
        text=True,
        timeout=40,
        check=False,
    )
    assert (ended.returncode, ended.stderr) == (1, NOTHING)
