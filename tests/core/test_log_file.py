"""The log file: what it has, when a new one begins, and that it never disturbs the program."""

import logging
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rosbase import (
    BaseManager,
    BaseNode,
    ConfigurationError,
    RosbaseLogger,
    log_to_file,
    make_logger,
)
from rosbase.logger.rotating_file import LogFile
from rosbase.logger.sizes import byte_count
from rosbase.testing import virtual_backend
from rosbase.utils import CustomLogger
from support.log_lines import without_times


@pytest.fixture(autouse=True)
def info_is_logged() -> None:
    logging.getLogger("rosbase").setLevel("INFO")


@pytest.fixture
def path(tmp_path: Path) -> Iterator[Path]:
    yield tmp_path / "logs" / "robot.log"
    log_to_file(None)


def lines_of(path: Path) -> list[str]:
    return without_times(path.read_text()).splitlines()


def all_lines(path: Path) -> list[str]:
    """The lines of the file and of the older ones, oldest first."""
    older = sorted(path.parent.glob(f"{path.name}.*"), key=lambda p: -int(p.suffix[1:]))
    return [line for file in [*older, path] for line in lines_of(file)]


def test_every_logger_of_the_program_writes_to_its_file(path: Path) -> None:
    log_to_file(path)
    manager = BaseManager("boss", {"camera": BaseNode}, backend=virtual_backend())
    manager.logger.info("ready")
    manager.nodes["camera"].logger.warning("dark\nand cold")
    manager.nodes["camera"].logger.debug("below the level")
    RosbaseLogger("other").get_child("part").error("lost")
    manager.destroy_node()
    assert lines_of(path) == [
        "[INFO] [boss]: ready",
        "[WARN] [boss.camera]: dark\\nand cold",
        "[ERROR] [other.part]: lost",
    ]


def test_what_the_applications_handlers_get_is_in_the_file_too(
    path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("WARNING", logger="rosbase")
    log_to_file(path)
    logger = RosbaseLogger("x")
    logger.info("quiet")
    logger.warning("loud")
    assert caplog.messages == ["loud"]
    assert lines_of(path) == ["[WARN] [x]: loud"]


def test_a_logger_of_the_applications_own_class_writes_to_the_file(path: Path) -> None:
    class Own:
        def __init__(self, name: str) -> None:
            self.lines: list[str] = []

        def info(self, message: str) -> None:
            self.lines.append(message)

    log_to_file(path)
    logger: Any = make_logger("x", Own)
    logger.info("hello")
    logger.warning("odd")
    assert logger.lines == ["hello"]
    assert lines_of(path)[0] == "[INFO] [x]: hello"


def test_a_traceback_is_indented_below_its_line(path: Path) -> None:
    log_to_file(path)
    try:
        raise ConnectionResetError("gone")
    except ConnectionResetError:
        RosbaseLogger("x").exception("failed")
    first, *below = lines_of(path)
    assert first == "[ERROR] [x]: failed"
    assert below[-1] == "  ConnectionResetError: gone"


def test_lines_are_appended_to_a_file_that_is_there(path: Path) -> None:
    path.parent.mkdir()
    path.write_text("before\n")
    log_to_file(path)
    RosbaseLogger("x").info("after")
    assert lines_of(path) == ["before", "[INFO] [x]: after"]


def test_a_full_file_is_moved_and_only_so_many_are_kept(path: Path) -> None:
    log_to_file(path, 200, 3)
    logger = RosbaseLogger("x")
    for number in range(100):
        logger.info("number %d", number)
    assert sorted(p.name for p in path.parent.iterdir()) == [
        "robot.log",
        *(f"robot.log.{number}" for number in (1, 2, 3)),
    ]
    assert all(p.stat().st_size <= 200 for p in path.parent.iterdir())
    written = all_lines(path)
    assert written == [f"[INFO] [x]: number {number}" for number in range(100 - len(written), 100)]


def test_a_size_of_0_never_begins_a_new_file(path: Path) -> None:
    log_to_file(path, 0)
    logger = RosbaseLogger("x")
    for _ in range(100):
        logger.info("again")
    assert [p.name for p in path.parent.iterdir()] == ["robot.log"]


def test_a_file_that_cannot_be_written_is_one_warning(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").write_text("")
    log_to_file(tmp_path / "file" / "robot.log")
    logger, other = RosbaseLogger("x"), RosbaseLogger("y")
    for _ in range(3):
        logger.info("hello")
        other.info("hello")
    (warning,) = (record for record in caplog.records if record.levelname == "WARNING")
    place = re.escape(f"{tmp_path}/file/robot.log")
    assert re.fullmatch(f"the log file {place} cannot be written: .+", warning.getMessage())
    assert caplog.messages.count("hello") == 6


def test_a_pipe_is_refused_and_does_not_block(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    os.mkfifo(tmp_path / "pipe")
    log_to_file(tmp_path / "pipe")
    RosbaseLogger("x").info("hello")
    assert caplog.messages[1].endswith("cannot be written: it is not a file")


def test_a_file_that_is_moved_or_deleted_begins_again(path: Path) -> None:
    log_to_file(path)
    logger = RosbaseLogger("x")
    logger.info("one")
    path.rename(path.with_suffix(".old"))
    logger.info("two")
    assert lines_of(path) == ["[INFO] [x]: two"]
    path.unlink()
    logger.info("three")
    assert lines_of(path) == ["[INFO] [x]: three"]
    assert lines_of(path.with_suffix(".old")) == ["[INFO] [x]: one"]


def test_a_file_goes_on_after_logging_has_closed_it(path: Path) -> None:
    log_to_file(path)
    logger = RosbaseLogger("x")
    logger.info("one")
    # As `logging.config` does with every handler there is.
    for reference in list(logging._handlerList):  # type: ignore[attr-defined]  # not documented
        handler = reference()
        if handler is not None and type(handler).__name__ == "LogFile":
            handler.close()
    logger.info("two")
    assert len(lines_of(path)) == 2


DISK_FULL = """
import resource, sys
from rosbase import RosbaseLogger, log_to_file
log_to_file(sys.argv[1])
logger = RosbaseLogger("x")
logger.info("one")
resource.setrlimit(resource.RLIMIT_FSIZE, (100, resource.RLIM_INFINITY))
for number in range(50):
    logger.info("too long %d %s", number, "a" * 50)
resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
logger.info("last")
"""


def test_a_disk_that_is_full_for_a_while_tears_no_line(path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", DISK_FULL, str(path)],
        capture_output=True, text=True, timeout=30, check=True,
    )  # fmt: skip
    assert done.stderr.count("cannot be written: File too large") == 1
    assert len(done.stderr.splitlines()) == 53
    written = lines_of(path)
    assert written[0] == "[INFO] [x]: one"
    assert written[-1] == "[INFO] [x]: last"
    whole = re.compile(r"\[INFO\] \[x\]: too long \d+ a{50}|\[WARN\] \[x\]: the log file .+")
    assert all(map(whole.fullmatch, written[1:-1]))


SEVERAL = """
import sys
from rosbase import RosbaseLogger, log_to_file
log_to_file(sys.argv[1], 5000, 1000)
logger = RosbaseLogger(sys.argv[2])
print("ready", flush=True)
sys.stdin.readline()
for number in range(500):
    logger.info("number %d %s", number, "a" * (number % 60))
"""


def test_several_programs_write_one_file_and_no_line_is_lost_or_torn(path: Path) -> None:
    programs = [
        subprocess.Popen(
            [sys.executable, "-c", SEVERAL, str(path), name],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        )
        for name in ("a", "b", "c")
    ]  # fmt: skip
    for program in programs:
        assert program.stdout is not None
        assert program.stdout.readline() == "ready\n"
    for program in programs:
        program.communicate("go\n", timeout=30)
        assert program.returncode == 0
    expected = [
        f"[INFO] [{name}]: number {number} {'a' * (number % 60)}"
        for name in ("a", "b", "c")
        for number in range(500)
    ]
    assert sorted(all_lines(path)) == sorted(expected)
    assert len(list(path.parent.iterdir())) > 10


PARENT = """
import os, sys
from rosbase import BaseHandlers, BaseManager, BaseNode, register_multiprocess_nodes

class Left(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        for number in range(50):
            self.logger.info("step %d", number)
        self.create_timer(0.01, self.request_stop)

class Waiting(BaseHandlers):
    def handle(self):
        if all(child.exit_code is not None for child in self.manager.children.values()):
            self.manager.request_stop()

if __name__ == "__main__":
    command = "echo file: $ROSBASE_LOG_FILE"
    children = register_multiprocess_nodes({"left": Left}, {"tool": command})
    manager = BaseManager("robot", handlers_class=Waiting)
    manager.children = children
    manager.logger.info("begins")
    manager.start_main_loop_timer(children)
"""


def test_children_write_into_the_file_of_their_manager(tmp_path: Path, path: Path) -> None:
    program = tmp_path / "robot.py"
    program.write_text(PARENT)
    done = subprocess.run(
        [sys.executable, str(program)],
        env={**os.environ, "ROSBASE_LOG_FILE": str(path)},
        capture_output=True, text=True, timeout=40, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert path.read_text() == done.stderr
    written = lines_of(path)
    # Before a manager has claimed its children, the logger has another name.
    steps = [line.partition("]: ")[2] for line in written if "step" in line]
    assert steps == [f"left: step {number}" for number in range(50)]
    assert any(line.endswith("tool: file:") for line in written)
    assert [p.name for p in path.parent.iterdir()] == ["robot.log"]


def test_the_environment_names_file_size_and_count(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROSBASE_LOG_FILE", str(path))
    monkeypatch.setenv("ROSBASE_LOG_FILE_SIZE", "200 B")
    monkeypatch.setenv("ROSBASE_LOG_FILE_COUNT", "2")
    node = BaseNode(node_name="x", backend=virtual_backend())
    for number in range(50):
        node.logger.info("number %d", number)
    node.destroy_node()
    assert len(list(path.parent.iterdir())) == 3


@pytest.mark.parametrize(("name", "text"), [("SIZE", "10 parsecs"), ("COUNT", "0"), ("COUNT", "x")])
def test_a_wrong_size_or_count_in_the_environment_is_named(
    path: Path, monkeypatch: pytest.MonkeyPatch, name: str, text: str
) -> None:
    monkeypatch.setenv("ROSBASE_LOG_FILE", str(path))
    monkeypatch.setenv(f"ROSBASE_LOG_FILE_{name}", text)
    with pytest.raises(ConfigurationError, match=f"ROSBASE_LOG_FILE_{name}={text}"):
        BaseNode(node_name="x", backend=virtual_backend())


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        *(("10 MB", 10_000_000), ("10MB", 10_000_000), ("1.5 GiB", 3 * 2**29), ("512 KiB", 2**19)),
        *(("0", 0), (4096, 4096), ("300 b", 300), (" 2 k ", 2000)),
    ],
)
def test_a_size_is_bytes_or_has_a_unit(text: str | int, expected: int) -> None:
    assert byte_count(text) == expected


@pytest.mark.parametrize("text", ["", "MB", "-1", "1 day", "10 MBit", "1e6", -5])
def test_what_is_no_size_is_refused(text: str | int) -> None:
    with pytest.raises(ValueError, match="no size of a file"):
        byte_count(text)


def test_a_custom_logger_has_a_level_and_a_file_of_its_own(
    path: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    log_to_file(tmp_path / "all.log")
    logger = CustomLogger("leg", level="debug", log_file=path)
    logger.debug("bent by %d", 3)
    logger.get_child("foot").info("on the ground", once=True)
    RosbaseLogger("other").info("not there")
    assert lines_of(path) == ["[DEBUG] [leg]: bent by 3", "[INFO] [leg.foot]: on the ground"]
    assert len(lines_of(tmp_path / "all.log")) == 3
    assert len(caplog.messages) == 3
    logger.close()
    logger.set_level(0)


def test_custom_loggers_with_one_path_share_the_file(path: Path) -> None:
    one, other = (CustomLogger(name, log_file=path, rotation=500, retention=50) for name in "ab")
    for number in range(100):
        (one if number % 3 else other).info("number %d", number)
    assert [line.split()[-1] for line in all_lines(path)] == [str(n) for n in range(100)]
    # The file of the program may be the same one; then each record is there once.
    log_to_file(path, 0)
    one.info("last")
    assert all_lines(path)[-2:] == ["[INFO] [b]: number 99", "[INFO] [a]: last"]


def test_a_custom_logger_serves_a_manager(path: Path) -> None:
    class Mine(CustomLogger):
        def __init__(self, name: str) -> None:
            super().__init__(name, log_file=path, rotation=None)

    manager = BaseManager("boss", custom_logger=Mine, backend=virtual_backend())
    assert isinstance(manager.logger, Mine)
    manager.logger.important("goal")
    manager.logger.close()
    manager.destroy_node()
    assert lines_of(path) == ["[INFO] [boss]: *** goal ***"]


LEVELS = ["debug", "info", "warning", "warn", "error", "critical", "fatal"]


@pytest.mark.parametrize("level", LEVELS)
def test_each_level_takes_values_and_the_filters(
    level: str, caplog: pytest.LogCaptureFixture
) -> None:
    logger = CustomLogger("x", level="DEBUG")
    say = getattr(logger, level)
    say("at %.1f m", 2.55)
    for number in range(3):
        say("once %d", number, once=True)
        say("skipped %d", number, skip_first=True)
        say("throttled %d", number, throttle_duration_sec=1000.0)
    logger.set_level(0)
    assert caplog.messages == [
        "at 2.5 m",
        "once 0",
        "throttled 0",
        "skipped 1",
        "skipped 2",
    ]


def test_the_size_of_a_file_is_in_bytes(tmp_path: Path) -> None:
    file = LogFile(str(tmp_path / "a.log"), 2_000, 3)
    try:
        for _ in range(6):
            # Some 650 bytes in 250 characters.
            file.emit(logging.LogRecord("a", logging.INFO, "", 0, "µ€" * 100 + "\udcff", (), None))
    finally:
        file.close()
    sizes = [path.stat().st_size for path in tmp_path.iterdir()]
    assert len(sizes) > 1
    assert max(sizes) <= 2_000
