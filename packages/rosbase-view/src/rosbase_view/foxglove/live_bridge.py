"""Running programs, seen and operated by the clients of the server."""

import threading
from collections.abc import Callable, Mapping
from typing import Any

from rosbase import Clock, ControlError, background_thread
from rosbase.control.questions.base import label
from rosbase_view.attached.streams import Streams
from rosbase_view.attached.surveying import Surveyor
from rosbase_view.attached.wanted import Tag
from rosbase_view.foxglove.asking import schema_of
from rosbase_view.foxglove.channels import Channels
from rosbase_view.foxglove.client_topics import ClientTopics
from rosbase_view.foxglove.graph import links
from rosbase_view.foxglove.listener import Listener
from rosbase_view.foxglove.notices import Notices
from rosbase_view.foxglove.parameter_desk import ParameterDesk
from rosbase_view.foxglove.server import Server
from rosbase_view.foxglove.service_desk import ServiceDesk
from rosbase_view.foxglove.wanted import wanted
from rosbase_view.reports import Survey

__all__ = ["LiveBridge"]

_LOOK_NS = 1_000_000_000
# Clients take the date of the server for now, and move on with it.
_TIME_NS = 50_000_000
_NOTHING = Survey((), {}, (), ())


class LiveBridge:
    """Joins running programs with a server.

    One thread looks once a second which programs run, and one reads the messages that clients
    listen to. Parameters and messages of clients have a thread each.
    """

    def __init__(
        self, name: str | None, clock: Clock, on_failure: Callable[[Exception], object]
    ) -> None:
        """Prepare for all programs, or for one and its child processes.

        Args:
            name: Name of a program, or the pid of its process.
            clock: Tells when to look again, and the date.
            on_failure: Takes an error that should not happen, with which a thread has ended.
        """
        self._name, self._clock, self._fail = name, clock, on_failure
        self._server = Server()
        self._notices = Notices(self._server)
        self._channels = Channels(self._server, self._notices, schema_of)
        self._parameters = ParameterDesk(self._server, self._notices, self._fail)
        self._services = ServiceDesk(self._server)
        self._client_topics = ClientTopics(self._channels, self._notices, self._fail)
        self._streams = Streams(self._take, self._refused, self._fail)
        self._surveyor = Surveyor(name)
        self._found = _NOTHING
        # Names of the programs at the last look, with their pids.
        self._programs: dict[str, str] = {}
        self._poke = threading.Event()
        self._is_closed = False
        self._thread = background_thread(self._run, "rosbase view foxglove")

    def start(self, name: str, host: str, port: int) -> int:
        """Listen, and begin to look; return the port.

        Raises:
            ConfigurationError: The port is in use, or there is no such address.
        """
        listener = Listener(self._channels, self._parameters, self._client_topics, self._poke.set)
        found = self._server.start(name, host, port, listener)
        self._parameters.start()
        self._client_topics.start()
        self._streams.start()
        self._thread.start()
        return found

    def close(self) -> None:
        """End all connections and threads; nothing goes on in the programs. Idempotent."""
        self._is_closed = True
        self._poke.set()
        if self._thread.ident is not None:
            self._thread.join()
        # Whoever answers clients ends after them.
        self._server.stop()
        self._streams.close()
        self._parameters.close()
        self._client_topics.close()

    def _run(self) -> None:
        try:
            self._look()
        except Exception as error:
            self._fail(error)

    def _look(self) -> None:
        due_ns = self._clock.monotonic_ns()
        while not self._is_closed:
            now_ns = self._clock.monotonic_ns()
            is_due = now_ns >= due_ns
            if is_due:
                self._update()
                due_ns = now_ns + _LOOK_NS
            if is_due or self._poke.is_set():
                self._poke.clear()
                self._streams.want(wanted(self._found, self._channels.listened()))
            self._server.send_time(self._clock.now_ns())
            self._poke.wait(_TIME_NS / 1e9)

    def _update(self) -> None:
        found = self._found = self._survey()
        # Before the channels, which clients use as soon as they see them.
        self._client_topics.update(found)
        self._parameters.update(found)
        topics = self._channels.update(found)
        services = self._services.update(found)
        self._server.send_links(links(topics, services))

    def _survey(self) -> Survey:
        try:
            found = self._surveyor.survey()
        except ControlError as error:
            # It may be started again.
            self._notices.say("program", str(error))
            return _NOTHING
        self._notices.end("program", f"program {self._name} is back")
        self._tell_programs(found)
        if found.trouble:
            self._notices.say("silent", found.trouble)
        else:
            self._notices.end("silent", "all programs answer again")
        return found

    def _tell_programs(self, found: Survey) -> None:
        """Tell which programs have ended since the last look, and which have come back."""
        before = self._programs
        self._programs = {process["name"]: label(process) for process in found.processes}
        for name in before.keys() - self._programs.keys():
            self._notices.say(f"program {name}", f"{before[name]} has ended")
        for name in self._programs.keys() - before.keys():
            self._notices.end(f"program {name}", f"{self._programs[name]} is back")

    def _take(
        self, tag: Tag, _answer: Mapping[str, Any], event: Mapping[str, Any], data: bytes
    ) -> None:
        """Take a message, on the thread that reads."""
        if tag.pid in self._found.silent:
            self._surveyor.ask_again(tag.pid)
        # One that the program has kept has no date.
        stamp_ns = event["stamp_ns"] or self._clock.now_ns()
        if tag.kind == "transform":
            self._channels.send_transform(tag.topic, stamp_ns, data)
            return
        self._channels.send(tag.topic, stamp_ns, data)
        if event["dropped"]:
            self._channels.count_dropped(tag.topic, tag.pid, event["dropped"])

    def _refused(self, tag: Tag, reason: str) -> None:
        self._notices.say(f"stream {tag.topic[0]}", f"{tag.topic[0]} is not sent: {reason}")
