"""No task misses what it waits for, in whatever order threads take their steps."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import TypeAlias

import pytest

from rosbase_ros2.turns import Turns

Steps: TypeAlias = Iterator[None]


class Task:
    """A task as rclpy's executor sees it."""

    def __init__(self) -> None:
        self.is_executing = False
        self.is_over = False


class World:
    """The threads of an executor, with a task that waits for something. Each yields after a step.

    The thread that looks sleeps until its guard is triggered, as it does in rclpy.
    """

    def __init__(self, bring: Callable[["World"], Steps]) -> None:
        self.turns = Turns()
        self.waiter, self.bringer = Task(), Task()
        self.is_there = False
        self.is_triggered = False
        self.running: list[Steps] = []
        for task, turn in ((self.waiter, self.wait()), (self.bringer, bring(self))):
            assert self.turns.begin(task)
            self.running.append(turn)

    def able(self) -> list[Callable[[], None]]:
        """The steps that may be taken now, each by another thread."""
        steps: list[Callable[[], None]] = [partial(self.step, turn) for turn in self.running]
        return [*steps, self.look] if self.is_triggered else steps

    def step(self, turn: Steps) -> None:
        if next(turn, self) is self:
            self.running.remove(turn)

    def look(self) -> None:
        """What rclpy does between two waits, with what `NativeExecutor` does with its offers."""
        self.is_triggered = False
        if not (self.waiter.is_executing or self.waiter.is_over) and self.turns.begin(self.waiter):
            self.running.append(self.wait())

    def wait(self) -> Steps:
        """One turn of the task that waits."""
        self.waiter.is_executing = True
        yield
        self.waiter.is_over = self.is_there
        yield
        self.waiter.is_executing = False
        yield
        self.is_triggered |= self.turns.end(self.waiter, is_over=self.waiter.is_over)


def callback(world: World) -> Steps:
    """A callback brings it; rclpy triggers the guard when it has run."""
    world.is_there = True
    yield
    world.is_triggered = True
    yield
    world.is_triggered |= world.turns.end(world.bringer, is_over=True)


def task(world: World) -> Steps:
    """A task of the program's brings it."""
    world.is_there = True
    yield
    world.is_triggered |= world.turns.end(world.bringer, is_over=True)


def coroutine(world: World) -> Steps:
    """A coroutine brings it, and waits for something else then."""
    world.is_there = True
    yield
    world.is_triggered |= world.turns.end(world.bringer, is_over=False)


def another_thread(world: World) -> Steps:
    """A thread of the program's brings it, and wakes the executor."""
    world.is_there = True
    yield
    world.turns.note_event()
    yield
    world.is_triggered = True


def schedules(bring: Callable[[World], Steps]) -> Iterator[World]:
    """Every order of steps, each as the world at its end."""
    pending: list[list[int]] = [[]]
    while pending:
        choices = pending.pop()
        world = World(bring)
        for choice in choices:
            world.able()[choice]()
        while able := world.able():
            pending += [[*choices, other] for other in range(1, len(able))]
            choices = [*choices, 0]
            able[0]()
        yield world


@pytest.mark.once
@pytest.mark.parametrize("bring", [callback, task, coroutine, another_thread])
def test_a_task_goes_on_whenever_the_event_comes(bring: Callable[[World], Steps]) -> None:
    number = 0
    for world in schedules(bring):
        assert world.waiter.is_over
        number += 1
    assert number > 10


@pytest.mark.once
def test_tasks_that_wait_do_not_resume_each_other() -> None:
    turns, tasks = Turns(), [Task() for _ in range(3)]
    for task in tasks:
        assert turns.begin(task)
    # The first turn may have done what another one waits for.
    assert [turns.end(task, is_over=False) for task in tasks] == [False, True, True]
    for _ in range(2):
        assert all(turns.begin(task) for task in tasks)
        assert not turns.begin(tasks[0])
        assert not any(turns.end(task, is_over=False) for task in tasks)
