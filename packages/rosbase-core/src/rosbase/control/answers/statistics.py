"""Answers about the main loop of a program."""

from typing import Any

from rosbase.control.answers.lookup import chosen_programs
from rosbase.control.answers.processes import tick_age_ns
from rosbase.control.programs import Program
from rosbase.control.requests import Answerer, Request
from rosbase.control.session import Session
from rosbase.runtime.histogram import Histogram

__all__ = ["ANSWERS"]

_PERCENTILES = {"p50": 50.0, "p90": 90.0, "p99": 99.0, "p999": 99.9}


def _statistics(session: Session, request: Request) -> dict[str, Any]:
    programs = chosen_programs(request.text("program", ""))
    return {"programs": [_described(program, session.now_ns()) for program in programs]}


def _described(program: Program, now_ns: int) -> dict[str, Any]:
    stats, backend = program.loop_stats, program.backend
    return {
        "program": program.name,
        "period": None if stats is None else _distribution(stats.period),
        "busy": None if stats is None else _distribution(stats.busy),
        "ticks": 0 if stats is None else stats.ticks,
        "overruns": 0 if stats is None else stats.overruns,
        "tick_ns": tick_age_ns(stats, now_ns),
        "rate_hz": program.facts().get("rate_hz"),
        "waiting_calls": None if backend is None else len(backend.executor.ready),
    }


def _distribution(histogram: Histogram) -> dict[str, Any]:
    buckets = histogram.buckets()
    return {
        "count": histogram.count,
        "min_ns": histogram.minimum(),
        **{name: histogram.percentile(percent) for name, percent in _PERCENTILES.items()},
        "max_ns": histogram.maximum,
        "histogram": buckets,
    }


ANSWERS: dict[str, Answerer] = {"statistics": _statistics}
