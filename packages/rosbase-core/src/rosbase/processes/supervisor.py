"""Watches over the children of a manager, on one thread: output, ends, restarts, the stop."""

import logging
import os
import selectors
import socket
import threading
from collections.abc import Callable, Iterable, Sequence

from rosbase.clock import Clock, SystemClock
from rosbase.logger import RosbaseLogger
from rosbase.processes.child import ChildProcess, Life, describe_end
from rosbase.processes.guardian import PATIENCE_S

__all__ = ["Supervisor"]

_NS_PER_S = 1_000_000_000
# Of a record, such as those of a traceback.
_MOST_LINES = 200
# The guardian keeps to its own time; this is for one that cannot.
_STOP_NS = int((PATIENCE_S + 1.0) * _NS_PER_S)


class Supervisor:
    """Starts children, and is there for them until all are stopped."""

    def __init__(
        self, children: Sequence[ChildProcess], logger: RosbaseLogger, clock: Clock | None = None
    ) -> None:
        self.logger = logger
        """Where output and ends are written. A manager puts its own here."""
        self._children = children
        self._clock = clock or SystemClock()
        self._selector = selectors.DefaultSelector()
        self._lives: list[Life] = []
        # When whom to start again, on the monotonic clock.
        self._due_ns: dict[ChildProcess, int] = {}
        self._stopping = False
        self._buffer = memoryview(bytearray(65_536))
        self._wake_r, self._wake_w = os.pipe()
        self._selector.register(self._wake_r, selectors.EVENT_READ, (None, self._woken))
        self._stop_lock = threading.Lock()
        self._thread = threading.Thread(target=self._run, name="children", daemon=True)

    def start(self) -> None:
        """Starts every child, then watches.

        Raises:
            OSError: One could not be started. Those before it have been stopped.
        """
        try:
            for child in self._children:
                self._start(child)
        except BaseException:
            self._thread.start()
            self.stop()
            raise
        self._thread.start()

    def stop(self) -> None:
        """Stops every child and returns when none is left, in bounded time. Idempotent."""
        with self._stop_lock:
            if self._wake_w < 0:
                return
            self._stopping = True
            os.write(self._wake_w, b"s")
            self._thread.join()
            self._selector.close()
            os.close(self._wake_w)
            os.close(self._wake_r)
            self._wake_w = -1

    # On the supervisor's thread.

    def _run(self) -> None:
        while not self._stopping:
            self._handle(self._next_due_s())
            self._start_due()
        self._due_ns.clear()
        for life in self._lives:
            life.ask_to_stop()
        ends_ns = self._clock.monotonic_ns() + _STOP_NS
        while self._lives and (left_ns := ends_ns - self._clock.monotonic_ns()) > 0:
            self._handle(left_ns / _NS_PER_S)
        for life in list(self._lives):
            life.kill()
            self._end(life)

    def _handle(self, timeout_s: float | None) -> None:
        for key, _ in self._selector.select(timeout_s):
            life, handle = key.data
            if life is None:
                handle()
                continue
            # It may have ended with an event that stood before this one in the list.
            if life not in self._lives:
                continue
            try:
                handle()
            except Exception as error:
                # One child that cannot be dealt with must not take the others along.
                self.logger.error(f"{life.child.name}: {error!r}", exc_info=error)
                life.kill()
                if life in self._lives:
                    self._end(life)

    def _woken(self) -> None:
        os.read(self._wake_r, 64)

    def _next_due_s(self) -> float | None:
        if not self._due_ns:
            return None
        return max(0, min(self._due_ns.values()) - self._clock.monotonic_ns()) / _NS_PER_S

    def _start_due(self) -> None:
        now_ns = self._clock.monotonic_ns()
        for child in [child for child, due_ns in self._due_ns.items() if due_ns <= now_ns]:
            del self._due_ns[child]
            try:
                self._start(child)
            except Exception as error:
                self.logger.error(f"{child.name}: cannot be started: {error}")
                self._plan_restart(child, failed=True, ran_s=0.0)

    def _start(self, child: ChildProcess) -> None:
        launched = child.launch.start(lambda level, text: self._record(child, level, text))
        life = Life(child, launched, self._clock.monotonic_ns())
        self._lives.append(life)
        self._watch(life, life.control, lambda: self._hear(life))
        self._watch(life, life.output, lambda: self._read(life))
        if life.ended_fd >= 0:
            self._watch(life, life.ended_fd, lambda: self._end(life))

    def _watch(self, life: Life, source: socket.socket | int, handle: Callable[[], object]) -> None:
        self._selector.register(source, selectors.EVENT_READ, (life, handle))

    def _ignore(self, source: socket.socket | int) -> None:
        if source in self._selector.get_map():
            self._selector.unregister(source)

    def _read(self, life: Life) -> bool:
        """Logs what there is to read; false if there is nothing now."""
        try:
            number = os.readv(life.output, [self._buffer])
        except BlockingIOError:
            return False
        if number:
            now_ns = self._clock.monotonic_ns()
            self._write(life, life.lines.feed(bytes(self._buffer[:number]), now_ns))
            return True
        self._ignore(life.output)
        return False

    def _hear(self, life: Life) -> None:
        goes_on = life.hear()
        if life.child.exit_code is not None:
            self._report(life)
        if not goes_on:
            self._end(life)

    def _end(self, life: Life) -> None:
        """Takes in its last words, and gives back what belonged to it."""
        self._lives.remove(life)
        for source in (life.control, life.output, life.ended_fd):
            self._ignore(source)
        life.hear()
        while self._read(life):
            pass
        self._write(life, life.lines.finish())
        life.finish()
        self._report(life)
        ran_s = (self._clock.monotonic_ns() - life.started_ns) / _NS_PER_S
        if not self._stopping:
            self._plan_restart(life.child, failed=life.child.exit_code != 0, ran_s=ran_s)

    def _plan_restart(self, child: ChildProcess, *, failed: bool, ran_s: float) -> None:
        restarts = child.restarts
        delay_s = restarts.after_end(failed=failed, ran_s=ran_s)
        if delay_s is not None:
            self._due_ns[child] = self._clock.monotonic_ns() + int(delay_s * _NS_PER_S)
            count = f"{restarts.in_a_row} of {restarts.policy.limit}"
            self.logger.warning(f"{child.name}: starting again in {delay_s:.1f} s ({count})")
        elif restarts.has_given_up:
            self.logger.error(f"{child.name}: not started again: {restarts.in_a_row} in a row")

    # Into the log.

    def _report(self, life: Life) -> None:
        child, code = life.child, life.child.exit_code
        if code is not None and not life.is_reported:
            life.is_reported = True
            write = self.logger.error if code and not self._stopping else self.logger.info
            write(f"{child.name}: {describe_end(code)}")
        if not child.is_alive and life.was_killed:
            self.logger.warning(f"{child.name}: had to be killed")
        if not child.is_alive and life.left:
            self.logger.error(f"{child.name}: could not be killed: {life.left}")

    def _write(self, life: Life, lines: Iterable[str]) -> None:
        for line in lines:
            self.logger.info(f"{life.child.name}: {line}")

    def _record(self, child: ChildProcess, level: int, text: str) -> None:
        methods = {
            logging.DEBUG: self.logger.debug,
            logging.WARNING: self.logger.warning,
            logging.ERROR: self.logger.error,
            logging.CRITICAL: self.logger.critical,
        }
        write = methods.get(level, self.logger.info)
        # Each with the name in front, as output: what stands below a record is the child's too.
        for line in text.splitlines()[:_MOST_LINES] or [""]:
            write(f"{child.name}: {line}")
