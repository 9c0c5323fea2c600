"""Random programs, recorded with threads, replay the same."""

import json
from typing import Any

from hypothesis import HealthCheck, given, settings

from rosbase import SystemClock
from rosbase.clock import Clock
from rosbase.entries.recorder import Recorder
from rosbase.entries.replaying.player import Player
from rosbase.entries.script import Entry, read_entries
from rosbase.entries.sink import RunFacts
from rosbase.testing import ManualClock, virtual_backend
from support.random_programs import (
    RandomProgram,
    changed_programs,
    from_json,
    random_programs,
    to_json,
)
from support.random_running import run_program

Run = tuple[list[Any], list[Entry], RunFacts]

few = settings(
    deadline=None, max_examples=30, suppress_health_check=list(HealthCheck), print_blob=True
)


def record(program: RandomProgram, clock: Clock) -> Run:
    recorder = Recorder(clock)
    facts = RunFacts(recorder.clock.start_date_ns, recorder.clock.start_ns)
    seen = run_program(program, virtual_backend(recorder.clock))
    assert recorder.spoiled == []
    return seen, list(read_entries([recorder.trace.take()])), facts


def replay(program: RandomProgram, script: list[Entry], facts: RunFacts) -> tuple[Any, Player]:
    # What an entry has is taken from it.
    player = Player(script, facts)
    seen = run_program(program, virtual_backend(player.clock))
    return seen, player


def check(program: RandomProgram, clock: Clock) -> None:
    seen, script, facts = record(program, clock)
    again, player = replay(program, script, facts)
    assert player.difference is None, player.difference
    assert again == seen


@few
@given(random_programs())
def test_a_program_in_virtual_time_replays_the_same(program: RandomProgram) -> None:
    check(program, ManualClock())


@settings(few, max_examples=5)
@given(random_programs())
def test_a_program_in_real_time_replays_the_same(program: RandomProgram) -> None:
    check(program, SystemClock())


@few
@given(changed_programs())
def test_a_changed_program_publishes_something_else(
    programs: tuple[RandomProgram, RandomProgram],
) -> None:
    one, other = programs
    seen, script, facts = record(one, ManualClock())
    again, _ = replay(other, script, facts)
    assert again != seen


@few
@given(random_programs())
def test_a_program_comes_back_from_json(program: RandomProgram) -> None:
    assert from_json(json.loads(json.dumps(to_json(program)))) == program
