"""Messages that wait for the disk."""

import os
import signal
import threading
from functools import partial

import pytest

from rosbase_mcap.backlog import Backlog
from rosbase_mcap.chunks import CHUNK_BYTES, MESSAGE_HEAD
from support.coming_in import coming_in
from support.open_chunks import messages_in
from support.waiting import wait_until


def add(backlog: Backlog, number: int, length: int = 100) -> bool:
    """Adds a message, of 131 bytes unless told otherwise."""
    return backlog.add(0, number, number, number, b"x" * length)


def taken(backlog: Backlog) -> list[int]:
    """Takes all, and returns the numbers."""
    return [one.sequence for one in messages_in(backlog.take())]


def test_messages_are_taken_in_the_order_in_which_they_came() -> None:
    backlog = Backlog(1 << 30)
    # Of all sizes: some are longer than a chunk, and some end one.
    lengths = [0, 1, CHUNK_BYTES, CHUNK_BYTES // 2, CHUNK_BYTES // 2, 5, 2 * CHUNK_BYTES, 0]
    for number, length in enumerate(lengths):
        assert add(backlog, number, length)
    chunks = backlog.take()
    found = messages_in(chunks)
    assert [one.sequence for one in found] == list(range(len(lengths)))
    assert [len(one.data) for one in found] == lengths
    assert all(chunk.size_bytes <= CHUNK_BYTES for chunk in chunks if chunk.count > 1)
    assert backlog.take() == []


def test_memory_that_is_given_back_is_used_again_for_other_messages() -> None:
    backlog = Backlog(1 << 30)
    seen = set()
    for number in range(10):
        add(backlog, number, number)
        (chunk,) = backlog.take()
        assert [one.sequence for one in messages_in([chunk])] == [number]
        assert chunk.times == {0: [number, 0]}
        seen.add(id(chunk))
        backlog.give_back(chunk)
    assert len(seen) <= 2
    for chunk in [*backlog.take(), *backlog.take()]:
        backlog.give_back(chunk)
    # A long message is no memory for short ones.
    add(backlog, 0, 2 * CHUNK_BYTES)
    (chunk,) = backlog.take()
    backlog.give_back(chunk)
    add(backlog, 1)
    assert taken(backlog) == [1]
    assert chunk.count == 1


def test_a_message_without_room_is_dropped_and_counted() -> None:
    backlog = Backlog(3 * 131)
    assert [add(backlog, number) for number in range(5)] == [True, True, True, False, False]
    assert backlog.dropped == 2
    assert taken(backlog) == [0, 1, 2]
    # There is room again.
    assert add(backlog, 5)


def test_a_short_message_finds_the_room_that_a_long_one_did_not() -> None:
    backlog = Backlog(1000)
    assert not add(backlog, 0, 2000)
    assert add(backlog, 1)
    assert taken(backlog) == [1]


def test_the_writer_is_woken_before_the_queue_is_full_and_not_by_each_message() -> None:
    backlog = Backlog(10 * MESSAGE_HEAD.size)
    for number in range(5):
        assert add(backlog, number, 0)
        backlog.wait(0.0)
        assert not backlog.is_wanted
    for number in range(5, 9):
        assert add(backlog, number, 0)
    assert backlog.is_wanted
    backlog.take()
    assert not backlog.is_wanted


def test_the_writer_can_wait_for_the_next_message() -> None:
    backlog = Backlog(1 << 20)
    is_over = threading.Event()

    def wait() -> None:
        backlog.wait_for_next(60.0)
        is_over.set()

    add(backlog, 0)
    writer = threading.Thread(target=wait)
    writer.start()
    wait_until(lambda: backlog._is_awaited, "the writer")
    add(backlog, 1)
    assert is_over.wait(20.0)
    writer.join()
    # Only once.
    add(backlog, 2)
    assert not backlog.wait(0.0)
    assert taken(backlog) == [0, 1, 2]


def test_threads_lose_no_message() -> None:
    backlog = Backlog(1 << 30)

    def fill() -> None:
        for number in range(1000):
            add(backlog, number, 1)

    threads = [threading.Thread(target=fill) for _ in range(4)]
    for thread in threads:
        thread.start()
    found: list[int] = []
    while any(thread.is_alive() for thread in threads):
        chunks = backlog.take()
        found += [one.sequence for one in messages_in(chunks)]
        for chunk in chunks:
            backlog.give_back(chunk)
    found += taken(backlog)
    assert sorted(found) == sorted([*range(1000)] * 4)


@pytest.mark.timeout(60)
@pytest.mark.parametrize("most_bytes", [31, 100, 1 << 20])
def test_a_signal_handler_may_add_a_message_in_the_middle_of_anything(most_bytes: int) -> None:
    moments, is_over = 0, False
    while not is_over:
        backlog = Backlog(most_bytes)
        added: dict[int, bool] = {}

        def put(number: int, to: Backlog, added: dict[int, bool]) -> None:
            added[number] = add(to, number, 0)

        with coming_in(partial(put, 1, backlog, added), skipping=moments):
            put(0, backlog, added)
            put(2, backlog, added)
            chunks = backlog.take()
        is_over = 1 not in added
        moments += 1
        found = messages_in([*chunks, *backlog.take()])
        assert sorted(one.sequence for one in found) == [n for n in sorted(added) if added[n]]
        assert backlog.dropped == list(added.values()).count(False)
    assert moments > 20


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
        os._exit(int(add(backlog, 0) or bool(backlog.take())))
    assert os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0
    is_over.set()
    holder.join()
    assert add(backlog, 1)
