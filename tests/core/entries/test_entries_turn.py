"""Who runs the program."""

import threading

import pytest

from rosbase.entries.turn import Turn


def on_thread(function: object) -> object:
    answers: list[object] = []
    thread = threading.Thread(target=lambda: answers.append(function()))  # type: ignore[operator]  # it is callable
    thread.start()
    thread.join()
    return answers[0]


def test_only_the_holder_is_inside() -> None:
    turn = Turn()
    assert not turn.is_mine
    assert turn.acquire()
    assert turn.is_mine
    assert on_thread(lambda: turn.is_mine) is False
    turn.release()
    assert not turn.is_mine


def test_another_thread_gets_the_turn_only_when_it_is_free() -> None:
    turn = Turn()
    turn.acquire()
    assert on_thread(turn.try_acquire) is False
    assert on_thread(lambda: turn.acquire(0.0)) is False
    turn.release()
    assert on_thread(turn.try_acquire) is True
    assert not turn.is_mine
    assert not turn.try_acquire()


@pytest.mark.parametrize("is_held", [True, False])
def test_the_thread_that_runs_the_program_takes_the_turn_over(is_held: bool) -> None:
    turn = Turn()
    if is_held:
        turn.acquire()

    def take_over() -> bool:
        turn.take_over()
        return turn.is_mine

    assert on_thread(take_over) is True
    assert not turn.try_acquire()
