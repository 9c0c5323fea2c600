"""Streams of events of several programs, on one thread and few connections."""

import select
import threading
from collections.abc import Callable, Mapping
from typing import Any

from rosbase import ControlError, WakePipe, background_thread
from rosbase.control.client import Connection, error_in
from rosbase.control.gathering import connect_to
from rosbase_view.attached.wanted import Question, Tag

__all__ = ["OnEvent", "Streams"]

OnEvent = Callable[[Tag, Mapping[str, Any], Mapping[str, Any], bytes], object]
"""Takes the tag, the answer before the first event, the event, and the bytes behind it."""

# A program takes 64 requests and streams on a connection.
_MOST_OPEN = 60


class Streams:
    """Keeps the streams open that are wanted, and passes their events on."""

    def __init__(
        self,
        on_event: OnEvent,
        on_refused: Callable[[Tag, str], object],
        on_failure: Callable[[Exception], object],
    ) -> None:
        """Prepare the thread. It calls the functions, which must be quick.

        Args:
            on_event: Takes the events.
            on_refused: Takes the reason why a stream was not opened. It is not asked for again
                while it is wanted with the same arguments.
            on_failure: Takes an error that should not happen, with which the thread ends.
        """
        self._on_event, self._on_refused = on_event, on_refused
        self._on_failure = on_failure
        self._wake = WakePipe()
        self._lock = threading.Lock()
        self._wanted: Mapping[Tag, Question] = {}
        self._adjusted: Mapping[Tag, Question] | None = None
        self._is_closed = False
        self._links: dict[int, _Link] = {}
        self._questions: dict[Tag, Question] = {}
        self._thread = background_thread(self._run, "rosbase view streams")

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def want(self, wanted: Mapping[Tag, Question]) -> None:
        """Say which streams should be open. Any thread may do so."""
        with self._lock:
            self._wanted = wanted
        self._wake.wake()

    def close(self) -> None:
        """End all streams and the thread."""
        with self._lock:
            self._is_closed = True
        self._wake.wake()
        if self._thread.ident is not None:
            self._thread.join()
        self._wake.close()

    def _run(self) -> None:
        poll = select.poll()
        poll.register(self._wake, select.POLLIN)
        try:
            while True:
                for fd, _ in poll.poll():
                    if fd in self._links:
                        self._read(fd, poll)
                self._wake.drain()
                with self._lock:
                    wanted, is_closed = self._wanted, self._is_closed
                if is_closed:
                    return
                # Not after each event: a stream that could not be opened waits for the next survey.
                if wanted is not self._adjusted:
                    self._adjusted = wanted
                    self._adjust(wanted, poll)
        except Exception as error:
            self._on_failure(error)
        finally:
            for link in self._links.values():
                link.connection.close()

    def _read(self, fd: int, poll: select.poll) -> None:
        link = self._links[fd]
        try:
            for frame, data in link.connection.frames():
                self._take(link, frame, data)
        except ControlError:
            # The program has ended. The next survey tells so, or brings it back.
            self._drop(fd, poll)

    def _take(self, link: "_Link", frame: dict[str, Any], data: bytes) -> None:
        number = frame.get("id")
        tag = link.tags.get(number) if isinstance(number, int) else None
        if number is None or tag is None:
            # Of a stream that was cancelled, or an error of the connection.
            return
        if "event" in frame:
            self._on_event(tag, link.answers.get(tag, {}), frame["event"], data)
        elif (error := error_in(frame)) is not None:
            del link.tags[number]
            self._on_refused(tag, str(error))
        elif "end" in frame:
            del link.tags[number]
            # If it is still wanted, it is asked for again after the next survey.
            self._questions.pop(tag, None)
        else:
            link.answers[tag] = frame.get("ok") or {}

    def _adjust(self, wanted: Mapping[Tag, Question], poll: select.poll) -> None:
        """Cancel and open streams until those that are open are the ones that are wanted."""
        for tag, question in list(self._questions.items()):
            if wanted.get(tag) != question:
                del self._questions[tag]
                self._cancel(tag, poll)
        for tag, question in wanted.items():
            if tag not in self._questions:
                self._open(tag, question, poll)
        for fd, link in list(self._links.items()):
            if not link.tags:
                self._drop(fd, poll)

    def _open(self, tag: Tag, question: Question, poll: select.poll) -> None:
        try:
            link = self._link_to(tag.pid, poll)
        except ControlError:
            # It has ended since the survey.
            return
        try:
            number = link.connection.send(question.ask, dict(question.arguments))
        except ControlError:
            self._drop(link.connection.fileno(), poll)
            return
        link.tags[number] = tag
        self._questions[tag] = question

    def _link_to(self, pid: int, poll: select.poll) -> "_Link":
        for link in self._links.values():
            if link.connection.pid == pid and len(link.tags) < _MOST_OPEN:
                return link
        link = _Link(connect_to(pid))
        self._links[link.connection.fileno()] = link
        poll.register(link.connection, select.POLLIN)
        return link

    def _cancel(self, tag: Tag, poll: select.poll) -> None:
        for fd, link in list(self._links.items()):
            number = next((n for n, known in link.tags.items() if known == tag), None)
            if number is None:
                continue
            del link.tags[number]
            link.answers.pop(tag, None)
            try:
                link.connection.send("cancel", {"of": number})
            except ControlError:
                self._drop(fd, poll)

    def _drop(self, fd: int, poll: select.poll) -> None:
        link = self._links.pop(fd)
        poll.unregister(fd)
        link.connection.close()
        for tag in link.tags.values():
            self._questions.pop(tag, None)


class _Link:
    """A connection with the streams that are open on it."""

    def __init__(self, connection: Connection) -> None:
        self.connection = connection
        self.tags: dict[int, Tag] = {}
        self.answers: dict[Tag, Mapping[str, Any]] = {}
