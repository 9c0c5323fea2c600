"""Our node and one of rclpy are asked the same. The answers differ only as the README says."""

import signal
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from support.code_blocks import ROOT
from support.ros_interview import (
    DEADLY,
    STARTS,
    deadly,
    finalized,
    graph,
    lifecycle,
    outcomes,
    parameters,
    samples,
    started,
    stopped,
    two_at_once,
    types,
)
from support.ros_twins import OURS, THEIRS, asked, shown

TOPICS = (graph, lifecycle, outcomes, parameters, types, samples, two_at_once, finalized)
TWINS = {"theirs": THEIRS, "ours": OURS}


def documented() -> dict[str, tuple[str, str]]:
    """The questions that are answered differently, with rclpy's answer and ours."""
    page = (ROOT / "packages/rosbase-ros2/README.md").read_text()
    section = page.split("\n### The same questions\n")[1].split("\n#")[0]
    rows = [line.strip("| ").split(" | ") for line in section.splitlines() if line[:2] == "| "]
    assert all(len(row) == 4 and row[3] for row in rows[1:])
    return {row[0].strip("`"): (row[1].strip("`"), row[2].strip("`")) for row in rows[1:]}


def interview(context: Any, folder: Path, twin: str) -> dict[str, str]:
    """Put every question; the answers as text."""
    answers: dict[str, Any] = {}

    def ask(*arguments: str) -> Any:
        return asked(context, folder, TWINS[twin], twin, *arguments)

    with ask() as asker:
        for topic in TOPICS:
            for question, answer in topic(asker):
                assert question not in answers, question
                answers[question] = answer
    for question, wanted in DEADLY.items():
        with ask() as asker:
            answers[question] = deadly(asker, wanted)
    for given in STARTS:
        with ask(*given.split()) as asker:
            answers |= {f"{question}, {given}": answer for question, answer in started(asker)}
    for signum in (signal.SIGINT, signal.SIGTERM):
        with ask() as asker:
            answers[f"status after {signum.name}"] = stopped(asker, signum)
    return {question: shown(answer, twin) for question, answer in answers.items()}


@pytest.mark.timeout(300)
def test_the_answers_are_those_of_a_node_of_rclpy_but_for_what_is_documented(
    context: Any, tmp_path: Path
) -> None:
    with ThreadPoolExecutor() as pool:
        theirs, ours = pool.map(partial(interview, context, tmp_path), TWINS)
    starts = [question for question in theirs if question.startswith("start, ")]
    apart = {question for question in starts if theirs[question] != ours[question]}
    # What only one of them lives to be asked.
    for question in set(theirs) ^ set(ours):
        assert f"start, {question.partition(', ')[2]}" in apart, question
    both = [question for question in theirs if question in ours]
    assert len(both) > 180
    different = {q: (theirs[q], ours[q]) for q in both if theirs[q] != ours[q]}
    assert different == documented()
