"""Watch the children of a manager on one thread: output, ends, restarts, the stop."""

import errno
import logging
import os
import selectors
import socket
import threading
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial

from rosbase.clock import Clock, SystemClock
from rosbase.logger import RosbaseLogger
from rosbase.processes.adoption import begin_adopting, end_adopting
from rosbase.processes.child import ChildProcess, Life
from rosbase.processes.guardian import PATIENCE_S
from rosbase.processes.journal import Journal
from rosbase.processes.judge import Judge
from rosbase.processes.launch import Order
from rosbase.processes.mark import Mark, Marks
from rosbase.processes.records import RecordLines
from rosbase.processes.survivors import name_survivors
from rosbase.runtime.signal_masks import background_thread

__all__ = ["Supervisor"]

_NS_PER_S = 1_000_000_000
# The guardian keeps to its own time; this is for one that cannot.
_STOP_NS = int((PATIENCE_S + 1.0) * _NS_PER_S)
_WAKE_AGAIN_S = 0.25
# More than a pipe holds. There may be somebody whom nobody can end, and who goes on writing.
_MOST_LAST_READS = 32


class Supervisor:
    """Starts children, and serves them until all are stopped."""

    def __init__(
        self,
        children: Sequence[ChildProcess],
        logger: RosbaseLogger,
        clock: Clock | None = None,
        *,
        judge: Judge | None = None,
    ) -> None:
        self.judge = Judge(Journal(logger)) if judge is None else judge
        self.journal = self.judge.journal
        self._children = children
        self._clock = clock or SystemClock()
        self._marks = Marks()
        self._lives: list[Life] = []
        # What other threads ask for.
        self._calls: deque[Callable[[], object]] = deque()
        self._buffer = memoryview(bytearray(65_536))
        self._has_begun = threading.Event()
        self._stopping = False
        self._stop_lock = threading.Lock()
        self._thread = background_thread(self._run, "children")
        self._wake_r, self._wake_w = os.pipe()
        try:
            self._selector = selectors.DefaultSelector()
            self._selector.register(self._wake_r, selectors.EVENT_READ, (None, self._woken))
        except BaseException:
            os.close(self._wake_r)
            os.close(self._wake_w)
            raise

    def start(self) -> None:
        """Start every child, then watch.

        Raises:
            OSError: One could not be started. Those before it have been stopped.
        """
        begin_adopting()
        try:
            self._thread.start()
        except RuntimeError as error:
            self._close()
            raise OSError(errno.EAGAIN, str(error)) from error
        try:
            for child in self._children:
                self._start(child)
        except BaseException:
            self.stop()
            raise
        self._has_begun.set()

    def call(self, function: Callable[[], object]) -> None:
        """Have a function run on the supervisor's thread. After `stop`, nothing happens."""
        if self._wake_w >= 0:
            self._calls.append(function)
            os.write(self._wake_w, b"c")

    def stopping_soon(self) -> None:
        """Stop acting on the ends of children: a stop has been requested.

        Call it from any thread or signal handler.
        """
        self.journal.is_ending = True

    def stop(self) -> None:
        """Stop every child, and return when none is left, in bounded time. Idempotent."""
        with self._stop_lock:
            if self._wake_w < 0:
                return
            self.stopping_soon()
            self._stopping = True
            self._has_begun.set()
            os.write(self._wake_w, b"s")
            self._thread.join()
            self._close()

    def _close(self) -> None:
        self._selector.close()
        os.close(self._wake_w)
        os.close(self._wake_r)
        self._wake_w = -1
        end_adopting()

    # On the supervisor's thread, but for the first starts, which come before.

    def begin(self, child: ChildProcess) -> None:
        """Start one child that is not running. For `call`.

        Raises:
            OSError: It could not be started.
        """
        self._start(child)

    def end(self, child: ChildProcess) -> None:
        """Ask one child to stop; the judge hears of its end. For `call`."""
        for life in self._lives:
            if life.child is child:
                life.was_asked = True
                life.ask_to_stop()

    def hurry(self) -> None:
        """Have all children end in less than a second. For `call`."""
        for life in self._lives:
            life.was_asked = True
            life.hurry()

    def _run(self) -> None:
        self._has_begun.wait()
        if not self._stopping:
            self._deal_with(None, partial(name_survivors, self._marks.program, self.journal))
        while not self._stopping:
            self._handle(self._patience_s())
            self._do_what_is_due()
        for life in self._lives:
            life.ask_to_stop()
        ends_ns = self._clock.monotonic_ns() + _STOP_NS
        while self._lives and (left_ns := ends_ns - self._clock.monotonic_ns()) > 0:
            self._handle(min(left_ns / _NS_PER_S, _WAKE_AGAIN_S))
            for life in self._lives:
                life.wake()
        for life in list(self._lives):
            life.kill()
            self._deal_with(None, partial(self._end, life))
        self.judge.close()

    def _handle(self, timeout_s: float | None) -> None:
        for key, _ in self._selector.select(timeout_s):
            life, handle = key.data
            # It may have ended with an event that stood before this one in the list.
            if life is None or life in self._lives:
                self._deal_with(life, handle)

    def _deal_with(self, life: Life | None, handle: Callable[[], object]) -> None:
        try:
            handle()
        except Exception as error:
            # One child that cannot be dealt with must not take the others along.
            name = life.child.name if life else "children"
            self.journal.logger.error(f"{name}: {error!r}", exc_info=error)
            if life in self._lives:
                life.kill()
                self._deal_with(None, partial(self._end, life))

    def _woken(self) -> None:
        os.read(self._wake_r, 64)
        while self._calls:
            self._calls.popleft()()

    def _patience_s(self) -> float | None:
        dues = [self.judge.due_ns, *(life.lines.due_ns for life in self._lives)]
        earliest_ns = min((due_ns for due_ns in dues if due_ns is not None), default=None)
        if earliest_ns is None:
            return None
        return max(0, earliest_ns - self._clock.monotonic_ns()) / _NS_PER_S

    def _do_what_is_due(self) -> None:
        now_ns = self._clock.monotonic_ns()
        for life in list(self._lives):
            lines = life.lines.tick(now_ns)
            self._deal_with(life, partial(self.journal.write_output, life, lines))
        for child in self.judge.to_start(now_ns):
            try:
                self._start(child)
            except Exception as error:
                self.journal.write(logging.ERROR, child.name, f"cannot be started: {error}")
                self.judge.could_not_start(child, now_ns)

    def _start(self, child: ChildProcess) -> None:
        mark, records = self._marks.make(child.name), RecordLines()
        on_record = partial(self._record, child.name, records)
        order = Order(mark, on_record, partial(self._fault_soon, mark))
        life = Life(child, child.launch.start(order), mark, records, self._clock)
        self._lives.append(life)
        handlers: dict[socket.socket | int, Callable[[Life], object]] = {
            life.control: self._hear,
            life.output: self._read,
            life.ended_fd: self._end,
        }
        try:
            for source, handle in handlers.items():
                if source != -1:
                    about = (life, partial(handle, life))
                    self._selector.register(source, selectors.EVENT_READ, about)
        except BaseException:
            life.kill()
            self._bury(life)
            raise

    def _ignore(self, source: socket.socket | int) -> None:
        if source != -1 and source in self._selector.get_map():
            self._selector.unregister(source)

    def _read(self, life: Life) -> bool:
        """Log available output; return False if there is none now."""
        try:
            number = os.readv(life.output, [self._buffer])
        except BlockingIOError:
            return False
        except OSError:
            # A terminal says so when nobody writes to it any more.
            number = 0
        if number:
            now_ns = self._clock.monotonic_ns()
            lines = life.lines.feed(bytes(self._buffer[:number]), now_ns)
            self.journal.write_output(life, lines)
            return True
        self._ignore(life.output)
        return False

    def _read_all(self, life: Life) -> None:
        for _ in range(_MOST_LAST_READS):
            if not self._read(life):
                return

    def _note_stop(self, life: Life) -> None:
        """Note whether a stop came before the end that is heard of now."""
        # Another thread may request a stop as soon as it sees the exit code.
        if life.child.exit_code is None:
            life.was_ending = self.journal.is_ending

    def _hear(self, life: Life) -> None:
        self._note_stop(life)
        goes_on = life.hear()
        if life.child.exit_code is not None and not life.may_be_a_stop and not life.is_reported:
            self._read_all(life)
            self.journal.write_end(life)
        if not goes_on:
            self._end(life)

    def _end(self, life: Life) -> None:
        self._bury(life)
        self.judge.ended(life, self._clock.monotonic_ns())

    def _bury(self, life: Life) -> None:
        """Read a child's last output, and release its resources."""
        self._lives.remove(life)
        for source in (life.control, life.output, life.ended_fd):
            self._ignore(source)
        self._note_stop(life)
        life.hear()
        life.finish()
        self._read_all(life)
        last_words = life.has_failed and not self.journal.is_ending
        self.journal.write_output(life, life.lines.finish(last_words=last_words))
        life.close()
        for level, text in life.records.finish():
            self.journal.write(level, life.child.name, text)

    def _stop_for_fault(self, mark: Mark, why: str) -> None:
        for life in self._lives:
            if life.mark == mark and not life.fault:
                life.fault = why
                self.journal.write(logging.ERROR, life.child.name, f"{why}; it is stopped")
                life.ask_to_stop()

    # On the threads of links.

    def _record(
        self, name: str, records: RecordLines, level: int, text: str, is_chosen: bool
    ) -> None:
        for line_level, line in records.take(level, text, self._clock.monotonic_ns()):
            self.journal.write(line_level, name, line, is_chosen=is_chosen)

    def _fault_soon(self, mark: Mark, why: str) -> None:
        self._calls.append(partial(self._stop_for_fault, mark, why))
        os.write(self._wake_w, b"f")
