"""`rosbase ps`, `stop` and `restart`."""

from __future__ import annotations

from rosbase.cli.operate.columns import columns, duration, long_tick, size
from rosbase.control.questions.programs import ProgramQuestions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from rosbase.control.shapes import Launched, Process, Program

__all__ = ["restart", "show_processes", "stop"]

_HEAD = ("PID", "PROGRAM", "KIND", "BACKEND", "STATE", "RATE", "TICKS", "OVERRUNS", "MEMORY", "UP")
_LAUNCHED_HEAD = ("PID", "NAME", "STATE", "RESTARTS", "REQUIRED", "EXIT")


def show_processes(given: Any) -> None:
    """Print the running programs as a table, or as JSON."""
    questions = ProgramQuestions(given.program)
    found, started = questions.processes_and_launched()
    if given.json:
        import json

        print(json.dumps({"processes": found, "launched": started}, indent=2))
        return
    rows = [row for process in found for row in _rows(process)]
    print(columns([_HEAD, *rows], right=(0, 5, 6, 7, 8, 9)))
    launchers = dict.fromkeys(one["launcher"] for one in started)
    for launcher in launchers:
        own = [_launched(one) for one in started if one["launcher"] == launcher]
        which = f" [{launcher}]" if len(launchers) > 1 else ""
        print(f"\nstarted by rosbase up{which}:\n{columns([_LAUNCHED_HEAD, *own], right=(0, 3))}")


def _rows(process: Process) -> list[tuple[str, ...]]:
    memory = size(process["memory_bytes"])
    rows: list[tuple[str, ...]] = []
    for program in process["programs"]:
        rows.append(
            (
                str(process["pid"]),
                program["name"].lstrip("/"),
                program["kind"],
                program["backend"] or "-",
                _state(program),
                "-" if program["rate_hz"] is None else f"{program['rate_hz']:g} Hz",
                str(program["ticks"]),
                str(program["overruns"]),
                memory,
                duration(program["up_ns"]),
            )
        )
        # Memory is of the process, so only once.
        memory = ""
    return rows


def _state(program: Program) -> str:
    """Return how far a program is: its own state while it runs."""
    if program["phase"] == "handshake" and program["waiting_for"]:
        return f"waiting for {', '.join(program['waiting_for'])}"
    state, phase = program["state"], program["phase"]
    if phase == "running" and state not in (None, ""):
        phase = f"running: {state}"
    hanging = long_tick(program.get("tick_ns"), program["rate_hz"])
    return f"{phase}, in one tick for {hanging}" if hanging else phase


def _launched(one: Launched) -> tuple[str, ...]:
    status = one.get("exit_status")
    return (
        "-" if one["pid"] is None else str(one["pid"]),
        one["name"],
        one["state"],
        str(one["restarts"]),
        "yes" if one["required"] else "no",
        "-" if status is None else str(status),
    )


def stop(given: Any) -> None:
    """End a program in order, and wait for its end."""
    print(f"stopped {ProgramQuestions().stop(given.name, timeout_s=given.timeout)}")


def restart(given: Any) -> None:
    """Start a program of `rosbase up` anew."""
    print(f"restarted {ProgramQuestions().restart(given.name)}")
