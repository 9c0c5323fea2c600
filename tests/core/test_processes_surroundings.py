"""What a child inherits from its manager: the Python, its options, folders, and an output."""

import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rosbase import register_multiprocess_nodes, shutdown_multiprocess_nodes
from rosbase.processes import ChildProcesses
from support.program import running
from support.waiting import wait_until

Register = Callable[..., ChildProcesses]


@pytest.fixture
def register(caplog: pytest.LogCaptureFixture) -> Iterator[Register]:
    caplog.set_level("INFO", logger="rosbase")
    started: list[ChildProcesses] = []

    def start(*args: Any, **kwargs: Any) -> ChildProcesses:
        started.append(register_multiprocess_nodes(*args, **kwargs))
        return started[-1]

    yield start
    for processes in started:
        shutdown_multiprocess_nodes(processes)


def wait_for(text: str, caplog: pytest.LogCaptureFixture, timeout_s: float = 20.0) -> None:
    wait_until(lambda: text in caplog.messages, text, timeout_s)


def level_of(text: str, caplog: pytest.LogCaptureFixture) -> str:
    return next(r.levelname for r in caplog.records if r.getMessage() == text)


# Output.

PYTHON = f"exec {sys.executable} -c"


def test_python_does_not_keep_back_what_it_prints(
    register: Register, caplog: pytest.LogCaptureFixture
) -> None:
    register({}, {"x": f"{PYTHON} 'import time; print(\"up\"); time.sleep(1000)'"})
    wait_for("x: up", caplog)


def test_whoever_wants_python_to_keep_it_back_decides(
    register: Register, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONUNBUFFERED", "")
    register({}, {"x": 'echo "<$PYTHONUNBUFFERED>"'})
    wait_for("x: <>", caplog)


@pytest.mark.parametrize(
    ("command", "texts"),
    [
        ("printf 'calibrate now? '; sleep 20", ["calibrate now? "]),
        ("printf 'Password: ' >&2; exec sleep 20", ["Password: "]),
        ("printf 'a\\nb'; exec sleep 20", ["a", "b"]),
        ("printf '10%%\\r20%%\\r'; exec sleep 20", ["10%", "20%"]),
        ("printf 'a\\r'; sleep 0.1; printf '\\nb'; exec sleep 20", ["a", "b"]),
        (f'{PYTHON} \'import time; print("> ", end=""); time.sleep(20)\'', ["> "]),
    ],
)
def test_a_line_that_was_begun_is_shown_after_a_second(
    register: Register, caplog: pytest.LogCaptureFixture, command: str, texts: list[str]
) -> None:
    register({}, {"x": command})
    wait_for(f"x: {texts[-1]}", caplog, 5.0)
    assert caplog.messages == [f"x: {text}" for text in texts]


def test_the_rest_of_a_line_that_was_begun_is_a_line_too(
    register: Register, caplog: pytest.LogCaptureFixture
) -> None:
    register({}, {"x": "printf 'ready? '; sleep 1.5; echo yes; exec sleep 20"})
    wait_for("x: yes", caplog)
    assert caplog.messages == ["x: ready? ", "x: yes"]


FLOOD = "i=0; while [ $i -lt 5000 ]; do echo $i; i=$((i+1)); done"


@pytest.mark.parametrize(
    ("end", "last"),
    [
        ("echo no more paper; exit 3", ["x: no more paper"]),
        ("printf 'no more ink'; exit 3", ["x: no more ink"]),
        ("echo bad; echo worse >&2; kill -SEGV $$", ["x: bad", "x: worse"]),
        (f"{PYTHON} 'int(\"ink\")'", ["x: Traceback (most recent call last):"]),
    ],
)
def test_the_last_words_of_a_child_that_crashes_in_a_flood_are_in_the_log(
    register: Register, caplog: pytest.LogCaptureFixture, end: str, last: list[str]
) -> None:
    processes = register({}, {"x": f"{FLOOD}; {end}"})
    wait_until(lambda: not processes["x"].is_alive, "its end")
    wait_until(lambda: "x: ended with" in caplog.text or "was ended by" in caplog.text, "news")
    assert set(last) <= set(caplog.messages)
    assert "x: 4999" in caplog.messages, "what came before them, as far as it is of use"
    assert len(caplog.messages) < 3000
    assert any("more lines" in text for text in caplog.messages)


TRACEBACKS = {
    "an exception": ('int("x")', "ValueError: invalid literal"),
    "a cause": (
        'exec("try: 1 / 0\\nexcept Exception as e: raise KeyError(7) from e")',
        "KeyError: 7",
    ),
    "a thread": (
        'import threading; t = threading.Thread(target=int, args=("x",)); t.start(); t.join()',
        "ValueError: invalid literal",
    ),
    "a syntax error": ("int(", "SyntaxError: "),
}
if sys.version_info >= (3, 11):
    TRACEBACKS["a group"] = (
        'raise ExceptionGroup("two", [ValueError(1), KeyError(2)])',
        "  | ExceptionGroup: two (2 sub-exceptions)",
    )


@pytest.mark.parametrize("kind", TRACEBACKS)
def test_a_traceback_is_an_error_in_the_log_and_other_output_is_not(
    register: Register, caplog: pytest.LogCaptureFixture, kind: str
) -> None:
    code, text = TRACEBACKS[kind]
    processes = register({}, {"x": f"echo before; {sys.executable} -c '{code}'; echo after"})
    wait_until(lambda: "x: ended with status 0" in caplog.messages, "its end")
    assert not processes["x"].is_alive
    first, *errors, after, _ = [(r.levelname, r.getMessage()) for r in caplog.records]
    assert first == ("INFO", "x: before")
    assert after == ("INFO", "x: after")
    assert {level for level, _ in errors} == {"ERROR"}
    assert any(message.startswith(f"x: {text}") for _, message in errors)


# A terminal.


def test_a_child_on_a_terminal_of_its_own_writes_as_if_somebody_looked(
    register: Register, caplog: pytest.LogCaptureFixture
) -> None:
    look = "test -t 1 && test -t 2 && echo terminal $TERM || echo pipe; sleep 1000"
    register({}, {"x": look, "y": look}, pty=["x"])
    wait_for("x: terminal dumb", caplog)
    wait_for("y: pipe", caplog)


@pytest.mark.parametrize("on_a_terminal", [True, False])
def test_a_program_that_keeps_its_output_back_does_not_on_a_terminal(
    register: Register, caplog: pytest.LogCaptureFixture, on_a_terminal: bool
) -> None:
    processes = register(
        {},
        {"x": "perl -e 'print qq(ready\\n); sleep 1000'", "y": "sleep 1.5; echo later"},
        pty={"x": on_a_terminal},
    )
    wait_for("y: later", caplog)
    assert ("x: ready" in caplog.messages) == on_a_terminal
    assert processes["x"].is_alive


def test_what_is_meant_for_a_screen_does_not_get_into_the_log(
    register: Register, caplog: pytest.LogCaptureFixture
) -> None:
    command = (
        "printf '\\033[1;31mred\\033[0m alert\\n\\033]0;title\\007\\033[2Ktwo\\r\\n\\033(Bthree\\n'"
    )
    processes = register({}, {"x": command}, pty=True)
    wait_until(lambda: not processes["x"].is_alive, "its end")
    wait_for("x: ended with status 0", caplog)
    assert caplog.messages == ["x: red alert", "x: two", "x: three", "x: ended with status 0"]


def test_a_terminal_takes_floods_ends_and_restarts_like_a_pipe(
    register: Register, caplog: pytest.LogCaptureFixture
) -> None:
    processes = register({}, {"x": "yes | head -n 100000; printf end; exit 3"}, pty="x")
    wait_until(lambda: not processes["x"].is_alive, "its end")
    wait_for("x: ended with status 3", caplog)
    assert "x: end" in caplog.messages
    assert len(caplog.messages) < 5000


def test_a_manager_without_a_terminal_does_not_get_that_of_its_child(tmp_path: Path) -> None:
    app = """
    import os, sys, time
    from rosbase import register_multiprocess_nodes, shutdown_multiprocess_nodes
    if __name__ == "__main__":
        os.setsid()
        processes = register_multiprocess_nodes({}, {"x": "sleep 1000"}, pty=True)
        try:
            os.open("/dev/tty", os.O_RDWR)
        except OSError:
            print("none")
        shutdown_multiprocess_nodes(processes)
    """
    with running(tmp_path, app) as program:
        status, out, err = program.end()
    assert (status, out) == (0, "none\n"), err


# Python, its options, and the folders.

NODE = """
import os, sys
from rosbase import BaseHandlers, BaseManager, BaseNode, register_multiprocess_nodes

class Node(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.logger.info(LOOK)
        self._request_stop()

class Handlers(BaseHandlers):
    def handle(self):
        if not processes["x"].is_alive:
            self.manager.request_stop()

if __name__ == "__main__":
    BEFORE
    processes = register_multiprocess_nodes({"x": Node}, {})
    BaseManager(handlers_class=Handlers).start_main_loop_timer(processes)
    print(processes["x"].exit_code)
"""


def run_node(folder: Path, look: str, before: str = "pass", **options: Any) -> str:
    """What the program and its node write into the log; both must end well."""
    app = NODE.replace("LOOK", look).replace("BEFORE", before)
    with running(folder, app, **options) as program:
        status, out, err = program.end()
    assert (status, out) == (0, "0\n"), err
    return err


def test_a_node_runs_in_the_python_that_multiprocessing_is_told_to_use(tmp_path: Path) -> None:
    wrapper = tmp_path / "python with arm"
    wrapper.write_text(f'#!/bin/sh\nARM=left exec {sys.executable} "$@"\n')
    wrapper.chmod(0o755)
    before = f"import multiprocessing; multiprocessing.set_executable({str(wrapper)!r})"
    assert "x: left" in run_node(tmp_path, "os.environ.get('ARM')", before)


def test_a_node_runs_in_python_though_the_program_is_embedded_in_another(tmp_path: Path) -> None:
    before = (
        "import multiprocessing; multiprocessing.set_executable(sys.executable);"
        " sys.executable = '/no/such/viewer'"
    )
    assert "x: here" in run_node(tmp_path, "'here'", before)


def test_a_node_has_the_options_of_the_program(tmp_path: Path) -> None:
    look = "f'{sys.flags.optimize} {sys.flags.dont_write_bytecode} {sys.warnoptions}'"
    said = run_node(tmp_path, look, options=["-O", "-B", "-W", "ignore::ImportWarning"])
    assert "x: 1 1 ['error', 'ignore::ImportWarning']" in said


TRAPS = ("random", "attr", "attrs", "logging", "rosbase", "pickle", "socket", "tempfile", "site")


@pytest.fixture
def trapped(tmp_path: Path) -> Path:
    """A folder with files that are called like modules; whoever imports one is told on."""
    folder = tmp_path / "data"
    folder.mkdir()
    for name in TRAPS:
        (folder / f"{name}.py").write_text(f"open({str(tmp_path / 'caught')!r}, 'w'); 1 / 0\n")
    return folder


def test_a_node_does_not_run_modules_of_the_current_folder(tmp_path: Path, trapped: Path) -> None:
    assert f"x: {trapped}" in run_node(tmp_path, "os.getcwd()", cwd=trapped)
    assert not (tmp_path / "caught").exists()


@pytest.mark.parametrize("path", [os.pathsep, "", f"{os.pathsep}/no/such", f"/no{os.pathsep}"])
def test_nor_if_the_search_path_has_an_empty_entry_and_the_program_goes_there_later(
    tmp_path: Path, trapped: Path, path: str
) -> None:
    before = f"os.chdir({str(trapped)!r})"
    said = run_node(tmp_path, "os.getcwd()", before, cwd=tmp_path, env={"PYTHONPATH": path})
    assert f"x: {trapped}" in said
    assert not (tmp_path / "caught").exists()


OPTIONS = [[], ["-m"], ["-I"], ["-s", "-E"]]
if sys.version_info >= (3, 11):
    OPTIONS.append(["-P"])


@pytest.mark.parametrize("options", OPTIONS)
def test_a_node_finds_the_modules_of_its_program_wherever_it_is_started(
    tmp_path: Path, options: list[str]
) -> None:
    (tmp_path / "own_part.py").write_text("WORD = 'found'\n")
    insert = "sys.path.append(os.path.dirname(os.path.abspath(__file__))); " * bool(
        {"-P", "-I"} & set(options)
    )
    look = f"(exec({insert + 'import own_part'!r}), sys.modules['own_part'].WORD)[1]"
    assert "x: found" in run_node(tmp_path, look, options=options, cwd=tmp_path)


def test_a_node_finds_what_the_program_has_put_on_its_search_path(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "own_part.py").write_text("WORD = 'found'\n")
    look = "__import__('own_part').WORD"
    before = "sys.path.insert(0, 'lib')"
    assert "x: found" in run_node(tmp_path, look, before, cwd=tmp_path)


def test_a_program_in_a_module_of_its_own_is_found_with_the_folder_in_which_it_began(
    tmp_path: Path,
) -> None:
    (tmp_path / "elsewhere").mkdir()
    look = "os.path.basename(os.getcwd())"
    said = run_node(tmp_path, look, "os.chdir('elsewhere')", options=["-m"], cwd=tmp_path)
    assert "x: elsewhere" in said


def test_a_node_knows_the_environment_of_its_manager_and_its_own_mark(tmp_path: Path) -> None:
    look = "f\"{os.environ['ARM']} {os.environ['PYTHONUNBUFFERED']}\""
    assert "x: left 1" in run_node(tmp_path, look, "os.environ['ARM'] = 'left'")
    assert "ROSBASE_CHILD_MARK" not in os.environ
