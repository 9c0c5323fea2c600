"""The source of running programs."""

import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from attrs import evolve

from rosbase import Clock, ControlError, SystemClock, background_thread
from rosbase.control.gathering import ask_one
from rosbase_view.attached.asking import NodeAsker, make_change
from rosbase_view.attached.inbox import Inbox
from rosbase_view.attached.refusals import Refusals
from rosbase_view.attached.streams import Streams
from rosbase_view.attached.surveying import Surveyor
from rosbase_view.attached.wanted import Tag, wanted
from rosbase_view.reports import Report, Said, Survey, TopicKey
from rosbase_view.source import Change, Gaze

__all__ = ["AttachedSource"]

_EVERY_NS = 1_000_000_000


class AttachedSource:
    """Looks at running programs through their control sockets; implements `Source`.

    One thread asks all programs once a second what they have, and one reads the streams. A change
    has a thread of its own, because a transition may take long.
    """

    can_change = True
    playback = None

    def __init__(self, name: str | None = None, clock: Clock | None = None) -> None:
        """Prepare to look at all programs, or at one and its child processes.

        Args:
            name: Name of a program, or the pid of its process.
            clock: Tells when to ask again.
        """
        self._name = name
        self._surveyor = Surveyor(name)
        self._clock = clock or SystemClock()
        self._inbox = Inbox()
        self._streams = Streams(self._take, self._refused, self._fail)
        self._refusals = Refusals()
        self._nodes = NodeAsker()
        self._found = Survey((), {}, (), ())
        self._gaze = Gaze()
        self._poke = threading.Event()
        self._is_closed = False
        self._failure: Exception | None = None
        self._thread = background_thread(self._run, "rosbase view survey")

    def check(self) -> None:
        """Check that the program runs.

        Raises:
            ControlError: No program has the name, or several have.
        """
        if self._name is not None:
            self._inbox.put(self._surveyor.survey())

    def start(self, on_news: Callable[[], object] | None = None) -> None:
        """Start the threads.

        Args:
            on_news: Called on any thread when there is something to take.
        """
        if on_news is not None:
            self._inbox.on_news = on_news
        self._streams.start()
        self._thread.start()

    def take(self) -> Sequence[Report]:
        """Return what was reported since the last call.

        Raises:
            Exception: A thread has ended with it, so that the view would show old data as new.
        """
        if self._failure is not None:
            raise self._failure
        return self._inbox.take()

    def look_at(self, gaze: Gaze) -> None:
        """Ask for what the user looks at."""
        self._inbox.pace = gaze.pace
        self._gaze = gaze
        self._poke.set()

    def schema_of(self, topic: TopicKey) -> tuple[str, str]:
        """Return the type of the messages, and its schema; may wait for a second.

        Raises:
            ControlError: There is no such topic, its messages have no schema, or its program does
                not answer.
        """
        found = self._found.topics.get(topic)
        if found is None:
            raise ControlError(f"there is no topic {topic[0]}", "unknown")
        pid = [*found["publishers"], *found["subscriptions"]][0]["pid"]
        answer = ask_one(pid, "topic.type", {"topic": found["name"]}, wait_s=1.0)[0]
        return answer["type"], answer["schema"]

    def change(self, change: Change) -> None:
        """Begin a change."""

        def run() -> None:
            self._inbox.put(make_change(change))
            self._poke.set()

        background_thread(run, "rosbase view change").start()

    def close(self) -> None:
        """End the threads. A change that has begun goes on in the program."""
        self._is_closed = True
        self._poke.set()
        if self._thread.ident is not None:
            self._thread.join()
        self._streams.close()

    def _run(self) -> None:
        try:
            self._look()
        except Exception as error:
            self._fail(error)

    def _fail(self, error: Exception) -> None:
        self._failure = error
        self._inbox.on_news()

    def _look(self) -> None:
        due_ns = self._clock.monotonic_ns()
        while not self._is_closed:
            now_ns = self._clock.monotonic_ns()
            if now_ns >= due_ns:
                self._found = self._survey()
                due_ns = now_ns + _EVERY_NS
                self._inbox.put(self._with_refusals(self._found))
            gaze = self._gaze
            streams = wanted(self._found, gaze)
            self._refusals.keep(streams)
            self._streams.want(streams)
            self._ask_nodes(self._found, gaze)
            self._poke.wait(max(0.0, (due_ns - self._clock.monotonic_ns()) / 1e9))
            self._poke.clear()

    def _survey(self) -> Survey:
        try:
            return self._surveyor.survey()
        except ControlError as error:
            # The view goes on, because the program may be started again.
            return Survey((), {}, (), (), trouble=str(error))

    def _with_refusals(self, found: Survey) -> Survey:
        """Return the survey with the reasons why something of it is not shown."""
        refused = self._refusals.line(found.processes)
        return evolve(found, trouble="; ".join(filter(None, (found.trouble, refused))))

    def _ask_nodes(self, found: Survey, gaze: Gaze) -> None:
        for node in found.nodes:
            if node.key not in gaze.nodes or node.key[1] in found.silent:
                continue
            try:
                report = self._nodes.ask(node.key, has_lifecycle=node.lifecycle is not None)
            except ControlError:
                # It has ended, or is busy: the next survey tells.
                continue
            self._inbox.put(report)

    def _take(
        self, tag: Tag, answer: Mapping[str, Any], event: Mapping[str, Any], data: bytes
    ) -> None:
        """Take an event, on the thread that reads the streams."""
        self._refusals.forget(tag)
        if tag.pid in self._found.silent:
            self._surveyor.ask_again(tag.pid)
        self._inbox.put_event(tag, answer, event, data)

    def _refused(self, tag: Tag, reason: str) -> None:
        # A topic without a ROS type cannot be shown, which matters only if it is looked at.
        if tag.kind == "echo":
            self._inbox.put(Said(reason, is_error=True))
        else:
            self._refusals.add(tag, reason)
