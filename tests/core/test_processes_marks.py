"""The mark by which the descendants of a child are known."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.clock import SystemClock
from rosbase.processes.adoption import end_family
from rosbase.processes.guardian import MARK_VARIABLE
from rosbase.processes.mark import (
    Mark,
    Marks,
    label_in,
    marked_environment,
    marks_in,
    program_identity,
)
from rosbase.processes.proc import read_of
from support.program import running
from support.strategies import child_marks
from support.waiting import wait_until

environments = st.lists(st.binary(max_size=30).filter(lambda text: b"\0" not in text))


@given(st.lists(child_marks), environments, environments)
def test_marks_are_found_in_an_environment_as_they_were_put_there(
    wanted: list[Mark], before: list[bytes], after: list[bytes]
) -> None:
    variable = f"{MARK_VARIABLE}={' '.join(map(str, wanted))}".encode()
    assert marks_in(b"\0".join([*before, variable, *after])) == wanted


@given(environments, st.binary(max_size=80))
def test_what_is_no_mark_is_none(others: list[bytes], value: bytes) -> None:
    assert marks_in(b"\0".join(others)) == []
    assert marks_in(f"{MARK_VARIABLE}=".encode() + value.replace(b".", b"-")) == []


def test_a_mark_is_added_to_those_that_the_manager_has_itself(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    outer, inner = Marks().make("outer child"), Marks().make("inner\nchild")
    monkeypatch.setenv(MARK_VARIABLE, str(outer))
    text = marked_environment(inner)[MARK_VARIABLE]
    assert marks_in(f"{MARK_VARIABLE}={text}".encode()) == [outer, inner]
    assert os.environ[MARK_VARIABLE] == str(outer)


def test_each_life_has_a_label_of_its_own() -> None:
    maker = Marks()
    assert len({maker.make("x").label for _ in range(100)}) == 100


LIMITS = """Limit                     Soft Limit           Hard Limit           Units
Max locked memory         8388608              8388608              bytes
Max file locks            {label:<20} unlimited            locks
Max pending signals       96365                96365                signals
"""


def test_a_label_is_found_in_the_limits_with_its_program_or_not_at_all() -> None:
    mark = Marks().make("x")
    limits = LIMITS.format(label=mark.label).encode()
    assert label_in(limits) == label_in(limits, mark.program) == mark.label
    other = f"{int(mark.program, 16) ^ 1:08x}"
    assert label_in(limits, other) is None


@pytest.mark.parametrize("label", ["unlimited", "0", "1024", str(1 << 61), str(2**64 - 1)])
def test_a_limit_that_is_no_label_is_none(label: str) -> None:
    limits = LIMITS.format(label=label).encode()
    assert label_in(limits) is None
    assert label_in(limits, "0" * 8) is None
    assert label_in(b"") is None


def test_a_program_has_the_same_name_each_time_and_another_program_another(
    tmp_path: Path,
) -> None:
    app = "from rosbase.processes.mark import program_identity; print(program_identity())"
    found = []
    for name in ("a", "a", "b"):
        folder = tmp_path / name
        folder.mkdir(exist_ok=True)
        with running(folder, app) as program:
            found.append(program.end()[1])
    assert found[0] == found[1] != found[2]
    assert found[0] != f"{program_identity()}\n"


class SlowMachine(SystemClock):
    """Each look at the processes takes longer than the time that there is for all."""

    def __init__(self) -> None:
        self._passed_ns = 0

    def monotonic_ns(self) -> int:
        self._passed_ns += 10_000_000_000
        return self._passed_ns


@pytest.mark.skipif(sys.platform != "linux", reason="marks are found in /proc")
def test_a_family_is_killed_on_a_machine_that_is_too_busy_to_look_in_time() -> None:
    mark = Marks().make("x")
    with subprocess.Popen(["sleep", "1000"], env=marked_environment(mark)) as process:
        wait_until(lambda: mark in marks_in(read_of(process.pid, "environ")), "its environment")
        assert end_family(mark, SlowMachine()) == []
        assert process.wait(10) == -signal.SIGKILL
