"""Record random programs on one Python, and replay them on others.

    python tests/replays.py record FOLDER [COUNT]
    python tests/replays.py replay FOLDER

It needs `tests` on the path of Python, and hypothesis to record. Status 1: a replay differs.
"""

import base64
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rosbase import SystemClock
from rosbase.clock import Clock
from rosbase.entries.recorder import Recorder
from rosbase.entries.replaying.player import Player
from rosbase.entries.script import read_entries
from rosbase.entries.sink import RunFacts
from rosbase.entries.trace import TraceBlock
from rosbase.testing import ManualClock, virtual_backend
from support.random_programs import RandomProgram, from_json, to_json
from support.random_running import run_program

# In real time, a program takes a fifth of a second.
REAL_EVERY = 10


def record_all(folder: Path, count: int) -> int:
    """Record some programs; return how many cannot be replayed."""
    from hypothesis import HealthCheck, Phase, given, seed, settings

    from support.random_programs import random_programs

    number, spoiled = 0, 0

    @seed(hash(sys.version_info[:2]))
    @settings(
        max_examples=count,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(random_programs())
    def make(program: RandomProgram) -> None:
        nonlocal number, spoiled
        number += 1
        clock = SystemClock() if number % REAL_EVERY == 0 else ManualClock()
        recorded = record(program, clock)
        spoiled += bool(recorded["spoiled"])
        (folder / f"{number}.json").write_text(json.dumps(recorded))

    make()
    print(f"{number} programs recorded with Python {sys.version.split()[0]}, {spoiled} spoiled")
    return spoiled


def record(program: RandomProgram, clock: Clock) -> dict[str, Any]:
    """Run a program, and return its recording as JSON has it."""
    recorder = Recorder(clock)
    seen = run_program(program, virtual_backend(recorder.clock))
    trace = recorder.trace.take().to_bytes()
    return {
        "program": to_json(program),
        "start_date_ns": recorder.clock.start_date_ns,
        "start_monotonic_ns": recorder.clock.start_ns,
        "trace": base64.b64encode(trace).decode(),
        "seen": [repr(one) for one in seen],
        "spoiled": recorder.spoiled,
    }


def replay_all(folder: Path) -> int:
    """Replay all recordings below a folder; return how many differ."""
    paths, faults = sorted(folder.rglob("*.json")), 0
    for path in paths:
        for fault in differences(json.loads(path.read_text())):
            faults += 1
            print(f"{path}: {fault}")
    print(f"{len(paths)} recordings replayed with Python {sys.version.split()[0]}, {faults} differ")
    return faults or not paths


def differences(recorded: dict[str, Any]) -> Iterator[str]:
    """Replay a program; yield the first difference, if there is one."""
    facts = RunFacts(recorded["start_date_ns"], recorded["start_monotonic_ns"])
    block = TraceBlock.from_bytes(base64.b64decode(recorded["trace"]))
    player = Player(read_entries([block]), facts)
    again = run_program(from_json(recorded["program"]), virtual_backend(player.clock))
    seen = recorded["seen"]
    if player.difference is not None:
        yield str(player.difference)
    elif [repr(one) for one in again] != seen:
        pairs = zip([repr(one) for one in again], seen, strict=False)
        yield next(
            (f"{new} instead of {old}" for new, old in pairs if new != old), "another length"
        )


def main(what: str, folder: str, count: str = "100") -> int:
    """Do what the command line says."""
    if what == "replay":
        return replay_all(Path(folder))
    here = Path(folder, f"{sys.version_info[0]}.{sys.version_info[1]}")
    here.mkdir(parents=True)
    return record_all(here, int(count))


if __name__ == "__main__":
    sys.exit(bool(main(*sys.argv[1:])))
