"""Messages that wait for the disk."""

import os
import signal
import threading

import pytest

from rosbase_mcap.backlog import Backlog, Item


def item(number: int, length: int = 100) -> Item:
    return (0, number, number, number, b"x" * length)


def test_messages_are_taken_in_the_order_in_which_they_came() -> None:
    backlog = Backlog(1 << 20)
    for number in range(3):
        assert backlog.add(item(number))
    assert [one[1] for one in backlog.take()] == [0, 1, 2]
    assert backlog.take() == []


def test_a_message_without_room_is_dropped_and_counted() -> None:
    backlog = Backlog(1000)
    assert [backlog.add(item(number)) for number in range(5)] == [True, True, True, False, False]
    assert backlog.dropped == 2
    assert len(backlog.take()) == 3
    # There is room again.
    assert backlog.add(item(5))


def test_the_writer_is_woken_before_the_queue_is_full_and_not_by_each_message() -> None:
    backlog = Backlog(1000)
    backlog.add(item(0))
    backlog.wait(0.0)
    assert not backlog.is_wanted
    backlog.add(item(1))
    assert backlog.is_wanted
    backlog.take()
    assert not backlog.is_wanted


def test_threads_lose_no_message() -> None:
    backlog = Backlog(1 << 30)

    def fill() -> None:
        for number in range(1000):
            backlog.add(item(number, 1))

    threads = [threading.Thread(target=fill) for _ in range(4)]
    for thread in threads:
        thread.start()
    taken = 0
    while any(thread.is_alive() for thread in threads):
        taken += len(backlog.take())
    taken += len(backlog.take())
    assert taken == 4000


@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
def test_a_forked_child_records_nothing_and_never_waits() -> None:
    backlog = Backlog(10_000)
    is_held, is_over = threading.Event(), threading.Event()

    def hold() -> None:
        with backlog._lock:
            is_held.set()
            is_over.wait()

    holder = threading.Thread(target=hold)
    holder.start()
    is_held.wait()
    pid = os.fork()
    if pid == 0:
        # Whoever waits for the lock does so for ever: there is no such thread here.
        signal.alarm(10)
        os._exit(int(backlog.add(item(0)) or bool(backlog.take())))
    assert os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0
    is_over.set()
    holder.join()
    assert backlog.add(item(1))
