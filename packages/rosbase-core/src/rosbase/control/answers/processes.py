"""Answers about this process and its programs, and the request to stop them."""

import os
import sys
from typing import Any

from rosbase.control.answers.lookup import chosen_programs
from rosbase.control.programs import Program, running_programs
from rosbase.control.requests import Answerer, Request
from rosbase.control.session import Session
from rosbase.control.usage import usage
from rosbase.control.version import rosbase_version
from rosbase.runtime.rate import LoopStats

__all__ = ["ANSWERS"]


def _process(session: Session, _: Request) -> dict[str, Any]:
    programs = running_programs()
    return {
        "pid": os.getpid(),
        "command": list(sys.orig_argv),
        "name": programs[0].name if programs else "",
        "python": ".".join(map(str, sys.version_info[:3])),
        "rosbase": rosbase_version(),
        **usage(),
        "programs": [_described(program, session.now_ns()) for program in programs],
        **session.counts(),
    }


def _described(program: Program, now_ns: int) -> dict[str, Any]:
    stats, backend = program.loop_stats, program.backend
    facts = {
        "name": program.name,
        "kind": program.kind,
        "class": program.class_name,
        "backend": None if backend is None else backend_name(backend),
        "network": "" if backend is None else backend.network,
        "phase": program.phase,
        "waiting_for": [],
        "state": None,
        "rate_hz": None,
        "ticks": 0 if stats is None else stats.ticks,
        "overruns": 0 if stats is None else stats.overruns,
        "tick_ns": tick_age_ns(stats, now_ns),
        "up_ns": now_ns - program.started_ns,
        "nodes": list(dict.fromkeys(node.name for node in program.nodes())),
        "children": [],
    }
    return {**facts, **program.facts()}


def tick_age_ns(stats: LoopStats | None, now_ns: int) -> int | None:
    """Return how long the tick that runs now has taken so far; None between two ticks."""
    started_ns = None if stats is None else stats.tick_started_ns
    return None if started_ns is None else max(0, now_ns - started_ns)


def backend_name(backend: object) -> str:
    """Return the name of a backend as users write it, as far as its class tells."""
    package = type(backend).__module__.partition(".")[0]
    is_ours = package == "rosbase"
    return "local" if is_ours else package.removeprefix("rosbase_")


def _stop(_: Session, request: Request) -> dict[str, Any]:
    programs = chosen_programs(request.text("program", ""))
    for program in programs:
        program.request_stop()
    return {"programs": [program.name for program in programs]}


ANSWERS: dict[str, Answerer] = {"process": _process, "stop": _stop}
