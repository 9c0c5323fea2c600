"""`rosbase view` of programs that run, on a terminal: at 80x24 and at 160x50, in tmux."""

import os
import shlex
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rosbase import ControlError, SystemClock
from rosbase.control import connect
from rosbase_view.attached.source import AttachedSource
from rosbase_view.attached.surveying import Surveyor
from rosbase_view.known import Known
from rosbase_view.reports import TopicKey
from rosbase_view.source import ChangeState, Gaze, SetParameter
from support.command import ROSBASE
from support.launching import OwnTmux, has_tmux, own_tmux
from support.operated import APP, LISTENER, Robots, pid_of, robots_in, run_both
from support.waiting import wait_until

pytestmark = pytest.mark.timeout(120)
needs_tmux = pytest.mark.skipif(not has_tmux(), reason="tmux is not installed")
SESSION = "view"


@pytest.fixture
def robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Robots]:
    with robots_in(tmp_path, monkeypatch) as found:
        yield found


class Looking:
    """A source and what is known from it."""

    def __init__(self, source: AttachedSource) -> None:
        self.source, self.known = source, Known()
        self._clock = SystemClock()

    def until(self, condition: Callable[[], object], what: str) -> None:
        def step() -> object:
            self.known.take(self.source.take(), self._clock.monotonic_ns())
            return condition()

        wait_until(step, what)


def rate_of(known: Known, key: TopicKey) -> float | None:
    return known.topics[key].rate_hz(SystemClock().monotonic_ns())


@pytest.fixture
def looking() -> Iterator[Looking]:
    source = AttachedSource()
    source.start()
    yield Looking(source)
    source.close()


def test_a_program_is_seen_with_all_that_it_has(robots: Robots, looking: Looking) -> None:
    pid = pid_of(robots.start(APP))
    known, key = looking.known, ("/position", pid)
    looking.until(lambda: key in known.topics and known.topics[key].total > 50, "messages")
    looking.until(lambda: (rate_of(known, key) or 0.0) > 50.0, "its rate")
    assert not known.heard
    looking.source.look_at(Gaze(topics=frozenset({key})))
    looking.until(lambda: key in known.heard, "a message")
    assert known.heard[key].message["z"] == -1.0
    assert looking.source.schema_of(key) == (known.heard[key].type, known.heard[key].schema)
    looking.until(lambda: any("five ticks" in one["text"] for one in known.log), "the log")
    assert any(one["program"] == "/app" for one in known.loops)


def test_a_program_is_changed(robots: Robots, looking: Looking) -> None:
    pid = pid_of(robots.start(APP))
    known, arm, robot = looking.known, ("/arm", pid), ("robot", pid)
    looking.until(lambda: arm in known.nodes, "the node")
    looking.source.look_at(Gaze(nodes=frozenset({arm})))
    looking.until(lambda: arm in known.node_reports, "its transitions")
    transition = known.node_reports[arm].transitions[0]
    before = known.nodes[arm].lifecycle
    looking.source.change(ChangeState(arm, transition))
    looking.until(lambda: known.nodes[arm].lifecycle != before, "another state")
    looking.source.look_at(Gaze(nodes=frozenset({robot})))
    looking.source.change(SetParameter(robot, "speed", "2"))
    looking.until(lambda: "speed is set" in str(known.said(0)), "what became of it")
    assert connect("app").get_parameters("robot")["speed"] == 2.0
    looking.source.change(SetParameter(robot, "speed", "fast"))
    looking.until(lambda: "speed is not set" in str(known.said(0)), "the refusal")


def test_a_program_that_ends_and_starts_again_is_seen_again(
    robots: Robots, looking: Looking
) -> None:
    first = robots.start(APP)
    known = looking.known
    looking.until(lambda: ("/position", pid_of(first)) in known.topics, "the topic")
    first.process.send_signal(signal.SIGINT)
    looking.until(lambda: not known.topics, "the end")
    key = ("/position", pid_of(robots.start(APP)))
    looking.until(lambda: key in known.topics and known.topics[key].total, "the topic again")


def test_a_program_that_does_not_answer_keeps_its_rows_until_it_does(
    robots: Robots, looking: Looking
) -> None:
    pid = pid_of(robots.start(APP))
    known, key = looking.known, ("/position", pid)
    looking.until(lambda: key in known.topics and known.topics[key].total > 50, "messages")
    total = known.topics[key].total
    os.kill(pid, signal.SIGSTOP)
    try:
        looking.until(lambda: known.silent == {pid}, "the silence")
    finally:
        os.kill(pid, signal.SIGCONT)
    assert known.topics[key].total >= total
    assert str(pid) in str(known.said(0))
    assert "no answer from app" in str(known.said(0))
    looking.until(lambda: not known.silent, "the answer")
    assert known.said(0) is None
    looking.until(lambda: known.topics[key].total > total + 50, "messages again")


def test_a_program_that_is_killed_while_it_is_silent_is_gone(
    robots: Robots, looking: Looking
) -> None:
    program = robots.start(APP)
    pid = pid_of(program)
    looking.until(lambda: looking.known.processes, "the program")
    os.kill(pid, signal.SIGSTOP)
    looking.until(lambda: looking.known.silent == {pid}, "the silence")
    program.process.kill()
    program.process.wait()
    looking.until(lambda: not looking.known.processes, "the end")
    assert looking.known.said(0) is None


def test_a_view_of_one_program_does_not_speak_of_others(robots: Robots) -> None:
    robots.start(APP)
    other = pid_of(robots.start(LISTENER))
    surveyor = Surveyor("app")
    assert surveyor.survey().trouble == ""
    os.kill(other, signal.SIGSTOP)
    try:
        found = surveyor.survey()
    finally:
        os.kill(other, signal.SIGCONT)
    assert (found.silent, found.trouble) == (frozenset(), "")
    assert len(found.processes) == 1


def test_a_view_of_one_program_waits_for_it_and_stays_with_it(robots: Robots) -> None:
    first = robots.start(APP)
    pid = pid_of(first)
    surveyor = Surveyor("app")
    assert [one["pid"] for one in surveyor.survey().processes] == [pid]
    again = pid_of(robots.start(APP))
    assert [one["pid"] for one in surveyor.survey().processes] == [pid]
    robots.start(LISTENER)
    first.stop(signal.SIGINT)
    assert [one["pid"] for one in surveyor.survey().processes] == [again]
    os.kill(again, signal.SIGINT)
    wait_until(lambda: len(connect().processes()) == 1, "the end")
    with pytest.raises(ControlError, match=r"^program app has ended; waiting until it runs again$"):
        surveyor.survey()


def test_a_view_that_is_closed_leaves_no_stream_in_the_program(robots: Robots) -> None:
    robots.start(APP)
    source = AttachedSource("app")
    source.check()
    source.start()
    found = Looking(source)
    found.until(lambda: found.known.topics, "the topics")
    source.close()
    wait_until(lambda: connect("app").processes()[0]["clients"] == 1, "no clients but this")


def test_a_thread_that_fails_ends_the_view_and_is_not_silent(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fail(*_: object) -> None:
        raise KeyError("an answer of another version")

    monkeypatch.setattr("rosbase_view.attached.source.Surveyor.survey", fail)
    source = AttachedSource()
    source.start()
    try:
        with pytest.raises(KeyError, match="another version"):
            Looking(source).until(lambda: False, "the error")
    finally:
        source.close()


def test_without_a_terminal_it_says_so_in_one_line(robots: Robots) -> None:
    assert "needs a terminal" in run_both("view", "nobody", status=2)[1]


def test_the_command_explains_itself(robots: Robots) -> None:
    assert "a program, or the pid of its process, with" in " ".join(
        run_both("view", "--help")[0].split()
    )


def screen(tmux: OwnTmux) -> str:
    return tmux("capture-pane", "-p", "-t", SESSION)


def start_view(tmux: OwnTmux, columns: int, rows: int, **environment: str) -> None:
    """Starts `rosbase view app` in a terminal of that size."""
    given = {"XDG_RUNTIME_DIR": os.environ["XDG_RUNTIME_DIR"], "PYTHONUTF8": "1", **environment}
    options = [word for name, value in given.items() for word in ("-e", f"{name}={value}")]
    size = ["-x", str(columns), "-y", str(rows)]
    tmux(
        "new-session",
        "-d",
        "-s",
        SESSION,
        *size,
        *options,
        f"exec {shlex.join([ROSBASE, 'view', 'app'])} 2>/dev/null",
    )


def keys(tmux: OwnTmux, *names: str) -> None:
    tmux("send-keys", "-t", SESSION, *names)


def choose(tmux: OwnTmux, row: str, mark: str = "▶") -> None:
    """Goes to a row of the page, one by one."""

    def places() -> tuple[int, int] | None:
        """Lines of the chosen row and of the wanted one."""
        lines = screen(tmux).splitlines()
        chosen = [y for y, line in enumerate(lines) if line.startswith(f"{mark} ")]
        wanted = [y for y, line in enumerate(lines) if line[2:].startswith(f"{row} ")]
        return (chosen[0], wanted[0]) if chosen and wanted else None

    wait_until(places, row)
    while (now := places()) is not None and now[0] != now[1]:
        keys(tmux, "Down" if now[0] < now[1] else "Up")
        wait_until(lambda now=now: places() != now, "the next row")  # type: ignore[misc]  # bound


@needs_tmux
@pytest.mark.parametrize(("columns", "rows"), [(80, 24), (160, 50)])
def test_the_screen_in_tmux(robots: Robots, tmp_path: Path, columns: int, rows: int) -> None:
    robots.start(APP)
    with own_tmux(tmp_path) as tmux:
        start_view(tmux, columns, rows)
        wait_until(lambda: " Hz " in screen(tmux), "a rate")
        choose(tmux, "/position")
        wait_until(lambda: "z -1" in screen(tmux), "a message")
        lines = screen(tmux).rstrip("\n").split("\n")
        assert lines[0].startswith("[1 topics]")
        assert "q quit" in lines[-1]
        assert all(len(line) <= columns for line in lines)
        tmux("send-keys", "-t", SESSION, "2")
        wait_until(lambda: "[2 nodes]" in screen(tmux), "the nodes")
        tmux("send-keys", "-t", SESSION, "q")
        wait_until(lambda: not tmux("list-sessions"), "the end of the view")


@needs_tmux
def test_a_terminal_without_colour_and_without_unicode(robots: Robots, tmp_path: Path) -> None:
    robots.start(APP)
    with own_tmux(tmp_path) as tmux:
        start_view(tmux, 80, 24, NO_COLOR="1", PYTHONUTF8="0", PYTHONIOENCODING="ascii")
        wait_until(lambda: " Hz " in screen(tmux), "a rate")
        coloured = tmux("capture-pane", "-p", "-e", "-t", SESSION)
        assert "\x1b[3" not in coloured.replace("\x1b[39m", "")
        assert screen(tmux).isascii()
        keys(tmux, "2")
        choose(tmux, "robot", mark=">")
        keys(tmux, "Enter")
        choose(tmux, "speed", mark=">")
        keys(tmux, "Enter")
        wait_until(lambda: "speed (double)" in screen(tmux), "the editor")
        assert screen(tmux).isascii()


@needs_tmux
def test_keys_drive_the_lifecycle_and_edit_a_parameter(robots: Robots, tmp_path: Path) -> None:
    robots.start(APP)
    with own_tmux(tmp_path) as tmux:
        start_view(tmux, 80, 24)
        wait_until(lambda: "[1 topics]" in screen(tmux), "the view")
        keys(tmux, "2")
        choose(tmux, "/arm")
        wait_until(lambda: "c  configure" in screen(tmux), "the transitions")
        keys(tmux, "c")
        wait_until(lambda: "a  activate" in screen(tmux), "the next transitions")
        keys(tmux, "a")
        wait_until(lambda: connect("app").lifecycle_state("arm")["state"] == "active", "the state")
        wait_until(lambda: "/arm is active" in screen(tmux), "the result")
        choose(tmux, "robot")
        keys(tmux, "Enter")
        choose(tmux, "speed")
        keys(tmux, "Enter")
        wait_until(lambda: "enter: set" in screen(tmux), "the editor")
        keys(tmux, "BSpace", "BSpace", "BSpace", "4", "Enter")
        wait_until(lambda: connect("app").get_parameters("robot")["speed"] == 4.0, "the value")
        wait_until(lambda: "speed is set" in screen(tmux), "the result")
        # The program refuses it, and the view says why.
        wait_until(lambda: "enter: set" not in screen(tmux), "the end of the editor")
        keys(tmux, "Enter")
        wait_until(lambda: "enter: set" in screen(tmux), "the editor again")
        keys(tmux, "x", "Enter")
        wait_until(lambda: "speed is not set: " in screen(tmux), "the refusal")


@needs_tmux
def test_a_suspended_view_does_not_delay_the_program_and_goes_on(
    robots: Robots, tmp_path: Path
) -> None:
    robots.start(APP)
    # A machine that does something else delays this one too.
    robots.start(APP.replace('BaseManager("app"', 'BaseManager("other"'))

    def loop_of(name: str) -> Any:
        return connect(name).statistics()[0]

    with own_tmux(tmp_path) as tmux:
        start_view(tmux, 80, 24)
        choose(tmux, "/position")
        wait_until(lambda: "z -1" in screen(tmux), "a message")
        view = int(tmux("list-panes", "-t", SESSION, "-F", "#{pane_pid}"))
        os.kill(view, signal.SIGSTOP)
        try:
            # More than the buffers between the two processes hold.
            app, other = loop_of("app"), loop_of("other")
            wait_until(lambda: loop_of("app")["ticks"] >= app["ticks"] + 1_000, "ticks", 60.0)
            viewed = loop_of("app")["overruns"] - app["overruns"]
            not_viewed = loop_of("other")["overruns"] - other["overruns"]
        finally:
            os.kill(view, signal.SIGCONT)
        assert viewed <= 30 + 2 * not_viewed
        before = screen(tmux)
        wait_until(lambda: screen(tmux) != before, "the view to go on")

        def has_ended() -> bool:
            # textual takes the terminal again, and may lose a key meanwhile.
            keys(tmux, "q")
            return not tmux("list-sessions")

        wait_until(has_ended, "the end of the view")
