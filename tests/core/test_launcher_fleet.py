"""When programs start, stop and start again: decided without a process and without time."""

import logging
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve
from hypothesis import given
from hypothesis import strategies as st

from rosbase.launcher.description import Condition, Program, read_mapping
from rosbase.launcher.description.tree import Faults
from rosbase.launcher.fleet import Entry, Fleet
from rosbase.processes import RestartPolicy
from support.strategies import waiting_programs

SECOND = 1_000_000_000
ACTIVE, EXIT_0 = Condition("lifecycle active"), Condition("exit 0")


class Notes:
    """Writes down what a fleet wants, and tells it that all has been done when it is asked to."""

    def __init__(self, *programs: Program, enabled: list[str] | None = None) -> None:
        self.done: list[str] = []
        self.said: list[str] = []
        self.now_ns = 0
        keys = [one.key for one in programs]
        self.fleet = Fleet(programs, keys if enabled is None else enabled, self)
        self.fleet.begin(0)

    def start(self, program: Program) -> None:
        self.done.append(f"start {program.key}")

    def stop(self, program: Program) -> None:
        self.done.append(f"stop {program.key}")

    def changed(self, entry: Entry) -> None:
        assert entry.state

    def say(self, key: str, level: int, text: str) -> None:
        self.said.append(f"{key} {logging.getLevelName(level)} {text}")

    def take(self) -> list[str]:
        """What it wanted since this was asked last."""
        done, self.done = self.done, []
        return done

    def started(self, *keys: str) -> None:
        for key in keys:
            self.fleet.started(key, self.now_ns)

    def ended(self, key: str, status: int = 0, *, ran_s: float = 1.0, told: bool = False) -> None:
        self.fleet.ended(key, status, ran_s, self.now_ns, was_told=told)

    def later(self, seconds: float) -> None:
        self.now_ns += int(seconds * SECOND)
        self.fleet.tick(self.now_ns)

    def state(self, key: str) -> str:
        return self.fleet.entries[key].state


def programs(**nodes: dict[str, Any]) -> list[Program]:
    """Programs by name, with their keys in a file."""
    faults = Faults()
    config = {"nodes": [{"name": name, "command": "x", **keys} for name, keys in nodes.items()]}
    description = read_mapping(config, Path("/"), faults)
    assert not faults.in_order()
    return list(description.programs)


def test_all_start_at_once_in_the_order_of_the_file_if_none_waits() -> None:
    notes = Notes(*programs(b={}, a={}, c={}))
    assert notes.take() == ["start b", "start a", "start c"]


def test_a_program_waits_until_the_other_meets_the_condition() -> None:
    notes = Notes(*programs(b={"after": {"a": "lifecycle active"}}, a={}))
    assert notes.take() == ["start a"]
    assert list(notes.fleet.wanted()) == [("a", ACTIVE)]
    notes.started("a")
    assert notes.take() == []
    assert notes.fleet.entries["b"].detail == "for a: lifecycle active"
    notes.fleet.met("a", ACTIVE, 0)
    assert notes.take() == ["start b"]
    assert list(notes.fleet.wanted()) == []


def test_a_condition_is_met_again_by_the_run_after_a_restart() -> None:
    a = {"restart": {"policy": "always", "backoff_s": 0}}
    notes = Notes(*programs(a=a, b={"after": {"a": "handshake"}}))
    notes.take()
    notes.ended("a", 1)
    # That came too late: the run that met it is over.
    notes.fleet.met("a", Condition("handshake"), 0)
    assert notes.take() == []
    notes.later(1)
    assert notes.take() == ["start a"]
    notes.fleet.met("a", Condition("handshake"), notes.now_ns)
    assert notes.take() == ["start b"]


def test_a_condition_that_has_held_counts_although_its_program_starts_again() -> None:
    a = {"restart": {"policy": "always", "backoff_s": 0}}
    notes = Notes(*programs(a=a, b={}, c={"after": {"a": "handshake", "b": "handshake"}}))
    notes.fleet.met("a", Condition("handshake"), 0)
    notes.ended("a", 1)
    notes.later(1)
    assert notes.take() == ["start a", "start b", "start a"]
    notes.fleet.met("b", Condition("handshake"), notes.now_ns)
    assert notes.take() == ["start c"]


def test_a_run_ends_if_all_that_is_left_waits_for_what_a_user_has_stopped() -> None:
    notes = Notes(*programs(a={}, b={"after": {"a": "handshake"}}, c={}))
    notes.fleet.stop("a", 0)
    notes.ended("a", 130)
    assert notes.state("b") == "waiting"
    notes.ended("c", 0)
    assert notes.said[-1] == "b ERROR cannot start: a was stopped, and it waits for a: handshake"
    assert notes.fleet.is_over


def test_a_long_chain_of_programs_fails_from_its_beginning_to_its_end() -> None:
    chain = {f"w{n}": {"after": {f"w{n - 1}": "exit 0"} if n else {}} for n in range(1500)}
    notes = Notes(*programs(**chain))
    notes.ended("w0", 3)
    assert notes.fleet.is_over
    text = "w1 ERROR cannot start: w0 has ended, and it waits for w0: exit 0"
    assert notes.said[0] == text
    text = "w2 ERROR cannot start: w1 never started, and it waits for w1: exit 0"
    assert notes.said[1] == text


def test_a_step_of_preparation_is_waited_for_to_its_end() -> None:
    notes = Notes(*programs(setup={}, robot={"after": {"setup": "exit 0"}}))
    notes.started("setup")
    assert notes.take() == ["start setup"]
    notes.ended("setup", 0)
    assert notes.take() == ["start robot"]
    assert notes.state("setup") == "ended"


def test_a_program_whose_condition_can_not_come_any_more_fails() -> None:
    notes = Notes(
        *programs(setup={}, robot={"after": {"setup": "exit 0"}}, free={}, last={"after": "robot"})
    )
    notes.ended("setup", 3)
    assert notes.state("robot") == notes.state("last") == "failed"
    text = "robot ERROR cannot start: setup has ended, and it waits for setup: exit 0"
    assert text in notes.said
    assert notes.state("free") == "running"
    notes.ended("free")
    assert notes.fleet.is_over
    assert notes.fleet.status == 1


def test_a_program_does_not_wait_for_longer_than_its_limit() -> None:
    waiting = {"after": {"a": "handshake"}, "after_timeout_s": 2}
    notes = Notes(*programs(a={}, b=waiting))
    notes.later(1.9)
    assert notes.state("b") == "waiting"
    assert notes.fleet.due_ns == 2 * SECOND
    notes.later(0.2)
    assert notes.said == ["b ERROR cannot start: has waited 2 s for a: handshake"]
    assert notes.state("b") == "failed"


def test_nobody_waits_for_a_disabled_program_and_is_told_so() -> None:
    notes = Notes(*programs(a={}, b={"after": {"a": "handshake"}}), enabled=["b"])
    assert notes.take() == ["start b"]
    assert notes.said == ["b WARNING does not wait for a: handshake, because a is disabled"]
    assert notes.state("a") == "disabled"


def test_a_program_restarts_by_its_policy_with_growing_delays_and_a_limit() -> None:
    restart = {"policy": "on-failure", "backoff_s": 1, "limit": 2}
    notes = Notes(*programs(a={"restart": restart}))
    delays = []
    for _ in range(2):
        notes.take()
        notes.ended("a", 1)
        assert notes.state("a") == "restarting"
        assert notes.fleet.due_ns is not None
        delays.append((notes.fleet.due_ns - notes.now_ns) / SECOND)
        # Seconds as a float may be a nanosecond too short.
        notes.later(delays[-1] + 1e-6)
        assert notes.take() == ["start a"]
    assert 0.5 <= delays[0] <= 1 <= delays[1] <= 2
    notes.ended("a", 7)
    assert notes.said == ["a ERROR not started again: 2 in a row"]
    assert (notes.state("a"), notes.fleet.entries["a"].total_restarts) == ("failed", 2)
    assert (notes.fleet.is_over, notes.fleet.status) == (True, 1)


def test_a_program_that_the_system_can_not_start_counts_as_failed() -> None:
    notes = Notes(*programs(a={}))
    notes.fleet.could_not_start("a", "no more processes", 0)
    assert notes.said == ["a ERROR cannot be started: no more processes"]
    assert notes.fleet.status == 1


def test_the_end_of_a_required_program_stops_the_others_in_reverse_order() -> None:
    notes = Notes(*programs(a={}, b={"required": True}, c={}, d={"after": {"c": "handshake"}}))
    assert notes.take() == ["start a", "start b", "start c"]
    notes.ended("b", 7)
    assert notes.take() == ["stop c"]
    assert notes.state("d") == "stopped"
    notes.ended("c", 130)
    assert notes.take() == ["stop a"]
    notes.ended("a", 1)
    assert (notes.fleet.is_over, notes.fleet.status) == (True, 7)


def test_a_required_program_that_is_started_again_ends_nothing() -> None:
    restart = RestartPolicy("always", limit=1, first_delay_s=0)
    one = evolve(programs(a={"required": True})[0], restart=restart)
    notes = Notes(one)
    notes.ended("a", 3)
    assert not notes.fleet.is_stopping
    notes.later(0.1)
    notes.ended("a", 0)
    assert (notes.fleet.is_stopping, notes.fleet.status) == (True, 0)


def test_a_required_program_that_can_not_start_ends_the_run() -> None:
    notes = Notes(*programs(a={}, b={"after": {"a": "exit 0"}, "required": True}, c={}))
    notes.ended("a", 3)
    assert notes.take()[-1] == "stop c"
    notes.ended("c")
    assert notes.fleet.status == 1


def test_whoever_is_slow_to_stop_holds_up_only_those_it_depends_on() -> None:
    notes = Notes(*programs(base={}, free={}, slow={"after": "base"}))
    notes.started("base")
    assert notes.take() == ["start base", "start free", "start slow"]
    notes.fleet.stop_all(0)
    assert notes.take() == ["stop slow"]
    notes.later(0.4)
    assert notes.take() == []
    assert notes.fleet.due_ns == SECOND // 2
    notes.later(0.1)
    assert notes.take() == ["stop free"]
    notes.later(5)
    assert notes.take() == []
    notes.ended("slow")
    assert notes.take() == ["stop base"]


def test_a_stop_that_was_asked_for_is_no_failure() -> None:
    notes = Notes(*programs(a={}, b={}))
    notes.ended("b", 1)
    notes.fleet.stop_all(0)
    notes.ended("a", 130)
    assert (notes.fleet.is_over, notes.fleet.status) == (True, 0)


def test_one_program_stops_without_consequences_and_starts_again() -> None:
    keys = {"required": True, "restart": "always"}
    notes = Notes(*programs(a=keys, b={}))
    notes.take()
    notes.fleet.stop("a", 0)
    assert (notes.take(), notes.state("a")) == (["stop a"], "stopping")
    notes.ended("a", 130)
    assert (notes.take(), notes.state("a")) == ([], "stopped")
    notes.fleet.restart("a", 0)
    assert (notes.take(), notes.state("a")) == (["start a"], "running")


def test_a_restart_stops_a_running_program_first() -> None:
    notes = Notes(*programs(a={}))
    notes.take()
    notes.fleet.restart("a", 0)
    notes.fleet.restart("a", 0)
    assert notes.take() == ["stop a"]
    notes.ended("a", 130)
    assert notes.take() == ["start a"]
    notes.fleet.restart("a", 0)
    notes.fleet.stop("a", 0)
    notes.take()
    notes.ended("a", 130)
    assert (notes.take(), notes.state("a")) == ([], "stopped")


def test_a_restart_starts_what_is_disabled_and_whoever_waits_for_nothing_else() -> None:
    notes = Notes(*programs(a={}, b={"after": "a"}), enabled=["b"])
    notes.take()
    notes.fleet.restart("a", 0)
    assert notes.take() == ["start a"]


def test_a_program_that_a_user_stops_in_its_pane_is_not_started_again() -> None:
    notes = Notes(*programs(a={"restart": "always", "required": True}, b={}))
    notes.take()
    notes.ended("a", 130, told=True)
    assert (notes.take(), notes.state("a"), notes.fleet.is_stopping) == ([], "stopped", False)


@pytest.mark.parametrize("state", ["waiting", "restarting"])
def test_what_does_not_run_stops_at_once(state: str) -> None:
    a = {"restart": "always"}
    notes = Notes(*programs(a=a, b={"after": {"a": "handshake"}}))
    notes.ended("a", 1)
    key = "a" if state == "restarting" else "b"
    assert notes.state(key) == state
    notes.fleet.stop(key, 0)
    assert notes.state(key) == "stopped"
    notes.take()
    notes.fleet.stop_all(0)
    assert notes.fleet.is_over
    notes.later(100)
    assert notes.take() == []


@given(waiting_programs(), st.randoms(use_true_random=False))
def test_in_any_order_of_events_starts_follow_and_stops_precede_what_they_depend_on(
    after: dict[str, list[str]], chance: Any
) -> None:
    conditions = {n: dict.fromkeys(others, "handshake") for n, others in after.items()}
    notes = Notes(*programs(**{n: {"after": c} for n, c in conditions.items()}))
    ready: set[str] = set()
    running: list[str] = []
    while len(ready) < len(after):
        running += [text.removeprefix("start ") for text in notes.take()]
        for name in running:
            assert set(after[name]) <= ready
        name = chance.choice([name for name in running if name not in ready])
        ready.add(name)
        notes.fleet.met(name, Condition("handshake"), 0)
    notes.fleet.stop_all(0)
    asked: list[str] = []
    while running:
        asked += [text.removeprefix("stop ") for text in notes.take()]
        for name in asked:
            assert not [other for other in running if name in after[other]]
        if asked and chance.random() < 0.7:
            name = asked.pop(chance.randrange(len(asked)))
            running.remove(name)
            notes.ended(name, 130)
        else:
            notes.later(0.5)
    assert notes.fleet.is_over
