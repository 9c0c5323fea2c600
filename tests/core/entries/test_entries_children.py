"""Children of a recorded program: a replay has none, and sees the same of them."""

import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rosbase import BaseManager, BaseNode, register_multiprocess_nodes
from rosbase.entries.conductor import Conductor
from rosbase.entries.current import conduct_next, running_conductor
from rosbase.entries.kinds import Kind
from rosbase.entries.recorder import Recorder
from rosbase.entries.replaying.player import Player
from rosbase.entries.script import Entry, read_entries
from rosbase.entries.sink import RunFacts
from rosbase.messages import String
from rosbase.testing.recorded_log import RecordedLog
from support.talking_child import Talker


class Listener(BaseNode):
    """Notes what it hears, and how many hear it."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.publisher: Any = self.create_publisher(String, "talk_back")
        self.create_subscription(String, "talk", lambda message: manager.see(message.data))


class Parent(BaseManager):
    """Looks at its children in each tick."""

    def __init__(self, children: Any, begun: Path) -> None:
        self.seen: list[Any] = []
        self.children = children
        self.begun = begun
        super().__init__("parent", {"listener": Listener}, node_freq_hz=50, control=False)

    def see(self, *values: Any) -> None:
        self.seen.append(values)

    def main_loop(self) -> None:
        super().main_loop()
        self.begun.touch()
        command = self.children["command"]
        is_alive, code = command.is_alive, command.exit_code
        self.see(is_alive, command.pid, code)
        self.see(self.node(Listener).publisher.subscription_count)
        heard = [seen for seen in self.seen if isinstance(seen[0], str)]
        # Its status is known a moment before it counts as ended.
        if len(heard) > 3 and code is not None and not is_alive:
            self.request_stop()


def run(folder: Path) -> list[Any]:
    begun = folder / "begun"
    begun.unlink(missing_ok=True)
    # What it says before the parent has a log would be missing there.
    command = f"until [ -e {begun} ]; do sleep 0.1; done; echo hello from the shell; exit 3"
    children = register_multiprocess_nodes({"talker": Talker}, {"command": command})
    parent = Parent(children, begun)
    parent.start_main_loop_timer(children)
    return parent.seen


@pytest.fixture
def heard() -> Iterator[RecordedLog]:
    log = RecordedLog("parent")
    yield log
    log.close()


def lines(log: RecordedLog) -> list[str]:
    found = [f"{logging.getLevelName(r.levelno)} {r.getMessage()}" for r in log.records]
    log.records.clear()
    return found


def test_a_replay_sees_children_that_it_does_not_start(heard: RecordedLog, tmp_path: Path) -> None:
    conductors: list[Conductor] = []

    def keep(conductor: Any) -> Any:
        conductors.append(conductor)
        return conductor

    conduct_next(lambda clock: keep(Recorder(clock)))
    seen = run(tmp_path)
    recorder: Any = conductors[0]
    assert recorder.spoiled == []
    entries: list[Entry] = list(read_entries([recorder.trace.take()]))
    said = lines(heard)
    assert "INFO command: hello from the shell" in said
    assert (False, seen[-2][1], 3) == seen[-2]
    kinds = [entry.kind for entry in entries]
    assert kinds.count(Kind.ARRIVE) >= 3
    # That would be a thread of rosbase which hands over something that no replay has.
    assert Kind.POSTED not in kinds

    facts = RunFacts(recorder.clock.start_date_ns, recorder.clock.start_ns)
    conduct_next(lambda clock: keep(Player(entries, facts)), is_replay=True)
    assert run(tmp_path) == seen
    player: Any = conductors[1]
    assert player.difference is None, str(player.difference)
    assert lines(heard) == said
    assert running_conductor() is None
