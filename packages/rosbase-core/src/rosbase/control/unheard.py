"""Tell a program of topics that it does not hear, because another program has them for itself.

The backend `local` joins the nodes of one program. Whoever starts two programs and expects them to
hear each other finds no error, and no message. So a program that subscribes to a topic without a
publisher looks, now and then, whether another program of the user publishes it, and says so once.

The thread of the control socket finds the topics. Other programs are asked on a thread of its own,
which is over in a second: two programs may ask each other at the same time.
"""

import os
from collections.abc import Callable, Mapping

from rosbase.control.folder import sockets
from rosbase.control.programs import Program, running_programs
from rosbase.errors import BackendError
from rosbase.local import LocalBackend
from rosbase.logger import RosbaseLogger
from rosbase.runtime.signal_masks import background_thread

__all__ = ["FIRST_LOOK_S", "Unheard"]

FIRST_LOOK_S = 5.0
"""How long a program has for its own publishers, in seconds."""
_LAST_PAUSE_S = 60.0
_MOST_TOPICS = 100
_NS_PER_S = 1_000_000_000


class Unheard:
    """Looks for topics that a program subscribes to and does not hear."""

    def __init__(self, now_ns: Callable[[], int], first_look_s: float = FIRST_LOOK_S) -> None:
        """Look for the first time after some seconds, then less and less often."""
        self._now_ns = now_ns
        self._pause_s = first_look_s
        self._told: set[str] = set()
        self._is_asking = False
        self.due_ns: int | None = now_ns() + int(first_look_s * _NS_PER_S)
        """When to call `look`, on the clock of `now_ns`; None if never again."""

    def look(self) -> None:
        """Look for such topics; on the thread of the control socket, at `due_ns`."""
        self._pause_s = min(2.0 * self._pause_s, _LAST_PAUSE_S)
        self.due_ns = self._now_ns() + int(self._pause_s * _NS_PER_S)
        if len(self._told) >= _MOST_TOPICS:
            self.due_ns = None
            return
        topics = {
            topic: program.logger
            for program in running_programs()
            if program.logger is not None
            for topic in _without_publisher(program)
            if topic not in self._told
        }
        if topics and not self._is_asking and any(pid != os.getpid() for pid, _ in sockets()):
            self._is_asking = True
            background_thread(lambda: self._ask(topics), "unheard topics").start()

    def _ask(self, topics: Mapping[str, RosbaseLogger]) -> None:
        """Ask the other programs for these topics, and warn."""
        # Most programs never need a client.
        from rosbase.control.buses import buses
        from rosbase.control.questions.base import label
        from rosbase.control.questions.topics import TopicQuestions

        try:
            questions = TopicQuestions(on_silent=None)
            found = {topic["name"]: topic for topic in questions.topics()}
            processes = questions.processes()
            own = next((b.pids for b in buses(processes) if os.getpid() in b.pids), frozenset())
            for topic, logger in topics.items():
                ends = found[topic]["publishers"] if topic in found else []
                others = {end["pid"] for end in ends} - own
                names = [label(process) for process in processes if process["pid"] in others]
                if names and own:
                    self._told.add(topic)
                    logger.warning(_warning(topic, names))
        finally:
            self._is_asking = False


def _without_publisher(program: Program) -> list[str]:
    """Return the topics that a program on `local` subscribes to and does not publish."""
    if not isinstance(program.backend, LocalBackend):
        return []
    try:
        graph = program.backend.graph()
    except BackendError:
        # Closed meanwhile.
        return []
    published = {end.name for end in graph.publishers}
    return sorted({end.name for end in graph.subscriptions} - published)


def _warning(topic: str, names: list[str]) -> str:
    which = "which does, is another program"
    if len(names) > 1:
        which = "which do, are other programs"
    return (
        f"nothing comes on {topic}: no node of this program publishes it, and "
        f"{' and '.join(names)}, {which}. The backend local joins the "
        "nodes of one program; to join programs, run them with ROSBASE_BACKEND=ros2"
    )
