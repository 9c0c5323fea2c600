"""Our node and one of rclpy are asked the same. The answers differ only as the README says."""

from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from support.code_blocks import ROOT
from support.ros import ros_context
from support.ros_interview import DEADLY, STARTS, Questions, deadly, everything, started
from support.ros_twins import OURS, THEIRS, UndiscoveredError, asked, shown

PAIRS = 3
TWINS = {"theirs": THEIRS, "ours": OURS}


def documented() -> dict[str, tuple[str, str]]:
    """The questions that are answered differently, with rclpy's answer and ours."""
    page = (ROOT / "packages/rosbase-ros2/README.md").read_text()
    section = page.split("\n### Answers to ROS tools\n")[1].split("\n#")[0]
    rows = [line.strip("| ").split(" | ") for line in section.splitlines() if line[:2] == "| "]
    assert all(len(row) == 4 and row[3] for row in rows[1:])
    return {row[0].strip("`"): (row[1].strip("`"), row[2].strip("`")) for row in rows[1:]}


def interview(context: Any, folder: Path, twin: str) -> dict[str, str]:
    """Put every question; the answers as text."""
    answers: dict[str, str] = {}

    def put(questions: Questions, *arguments: str, pairs: int = PAIRS) -> None:
        # Each in a namespace of its own: ROS sees a node for a while after it was killed.
        namespace = f"{twin}{len(answers)}of{pairs}"
        try:
            # It may be the context that does not discover the node.
            with (
                nullcontext(context) if pairs == PAIRS else ros_context() as asking,
                asked(asking, folder, TWINS[twin], namespace, *arguments) as asker,
            ):
                found = [
                    (question, shown(answer, namespace)) for question, answer in questions(asker)
                ]
        except UndiscoveredError:
            if pairs == 1:
                raise
            put(questions, *arguments, pairs=pairs - 1)
            return
        for question, answer in found:
            assert question not in answers, question
            answers[question] = answer

    put(everything)
    for question in DEADLY:
        put(partial(deadly, question=question))
    for given in STARTS:
        put(partial(started, given=given), *given.split())
    return answers


@pytest.mark.once
@pytest.mark.timeout(600)
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
