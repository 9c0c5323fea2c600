"""Topics that another program has for itself: when a program looks for them, and what it says."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rosbase import BaseNode
from rosbase.contracts.backend import BackendOptions
from rosbase.control import unheard
from rosbase.control.programs import Program
from rosbase.control.unheard import Unheard
from rosbase.local import Bus, LocalBackend
from rosbase.messages import Point
from support.operated import APP, Robots, robots_in

SECOND_NS = 1_000_000_000


class Log:
    """Keeps warnings."""

    def __init__(self) -> None:
        self.warnings: list[str] = []

    def warning(self, text: str) -> None:
        self.warnings.append(text)


class Rig:
    """A watch, with a clock and a program of the test's."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_ns = 0
        self.backend = LocalBackend(BackendOptions("own"), Bus())
        self.log = Log()
        program: Any = Program()
        program.backend, program.logger = self.backend, self.log
        monkeypatch.setattr(unheard, "running_programs", lambda: (program,))
        monkeypatch.setattr(unheard, "background_thread", lambda target, _: _Now(target))
        self.watch = Unheard(lambda: self.now_ns)

    def look(self) -> list[str]:
        """Looks at the time at which it is due; gives the warnings so far."""
        assert self.watch.due_ns is not None
        self.now_ns = self.watch.due_ns
        self.watch.look()
        return self.log.warnings


class _Now:
    """A thread that runs at once, on the thread that starts it."""

    def __init__(self, target: Any) -> None:
        self.start = target


@pytest.fixture
def robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Robots]:
    with robots_in(tmp_path, monkeypatch) as found:
        yield found


@pytest.fixture
def rig(robots: Robots, monkeypatch: pytest.MonkeyPatch) -> Iterator[Rig]:
    rig = Rig(monkeypatch)
    yield rig
    rig.backend.close()


def test_it_looks_after_five_seconds_and_then_less_and_less_often(rig: Rig) -> None:
    times = []
    for _ in range(7):
        rig.look()
        times.append(rig.now_ns // SECOND_NS)
    assert times == [5, 15, 35, 75, 135, 195, 255]


def test_a_program_that_hears_all_of_its_topics_asks_nobody(
    rig: Rig, robots: Robots, monkeypatch: pytest.MonkeyPatch
) -> None:
    robots.start(APP)
    rig.backend.create_publisher(Point, "position", 10)
    rig.backend.create_subscription(Point, "position", print, 10)
    monkeypatch.setattr(unheard, "sockets", lambda: pytest.fail("it asks"))
    assert rig.look() == []


def test_nobody_is_asked_where_nobody_else_runs(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    rig.backend.create_subscription(Point, "position", print, 10)
    monkeypatch.setattr(unheard, "sockets", lambda: [(os.getpid(), "own.sock")])
    monkeypatch.setattr(unheard, "background_thread", lambda *_: pytest.fail("it asks"))
    assert rig.look() == []


def test_a_program_is_told_once_of_each_topic_that_it_does_not_hear(
    robots: Robots, monkeypatch: pytest.MonkeyPatch
) -> None:
    pids = sorted(robots.start(APP).process.pid for _ in range(2))
    looks: list[Unheard] = []

    class Early(Unheard):
        """Looks at once."""

        def __init__(self, now_ns: Any) -> None:
            super().__init__(now_ns, 0.05)
            looks.append(self)

    monkeypatch.setattr("rosbase.control.server.Unheard", Early)
    node = BaseNode(node_name="listener")
    warnings: list[str] = []
    monkeypatch.setattr(node.logger, "warning", warnings.append)
    node.create_subscription(Point, "position", print)
    node.create_subscription(Point, "goal", print)

    def end_when_told() -> None:
        if warnings:
            node.request_stop()

    node.create_timer(0.05, end_when_told)
    node.start_spin_standalone()
    assert len(looks) == 1
    assert len(warnings) == 1
    assert warnings[0].startswith(
        "nothing comes on /position: no node of this program publishes it, and "
        f"app [{pids[0]}] and app [{pids[1]}], which do, are other programs. "
    )


def test_several_other_programs_are_named_in_the_plural() -> None:
    text = unheard._warning("/fast", ["fast [1]", "fast [2]"])
    assert "fast [1] and fast [2], which do, are other programs. The backend" in text
