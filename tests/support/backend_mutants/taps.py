"""What is wrong with taps and the graph."""

from collections.abc import Callable
from typing import Any

from attrs import evolve

from rosbase.contracts.backend import BackendOptions
from rosbase.contracts.graph import Graph
from rosbase.contracts.message_format import MessageFormat
from rosbase.contracts.tap import Tap
from rosbase.errors import BackendError
from rosbase.local import LocalBackend
from rosbase.messages import Imu
from support.backend_mutants.changed import Changed, breaks


@breaks("taps-hear-what-is-published")
class TapsOnlyWhatIsThere(LocalBackend):
    """Publishers that come later are not tapped."""

    def create_publisher(self, msg_type: Any, topic: Any, qos_profile: Any) -> Any:
        publisher: Any = super().create_publisher(msg_type, topic, qos_profile)
        publisher.set_taps(())
        return publisher


@breaks("taps-hear-what-is-published")
class TapsPublishButNotSenders(LocalBackend):
    def prepared_sender(self, publisher: Any, template: Any, varying: Any) -> Any:
        taps = publisher._taps
        send = super().prepared_sender(publisher, template, varying)

        def send_untapped(*values: Any) -> object:
            publisher.set_taps(())
            try:
                return send(*values)
            finally:
                publisher.set_taps(taps)

        return send_untapped


@breaks("taps-hear-what-is-published")
class TapsEachPublishTwice(LocalBackend):
    def add_tap(self, topic: str, on_message: Callable[[Any], object]) -> Tap:
        def twice(message: Any) -> None:
            on_message(message)
            on_message(message)

        return super().add_tap(topic, twice)


@breaks("taps-hear-what-arrives")
class TapsEachSubscription(LocalBackend):
    def create_subscription(
        self, msg_type: Any, topic: Any, callback: Any, qos_profile: Any
    ) -> Any:
        name = self._check(topic)

        def hear(message: Any) -> None:
            for tap in self._bus._taps.get(name, ()):
                tap.take(message)
            callback(message)

        return super().create_subscription(msg_type, topic, hear, qos_profile)


@breaks("taps-hear-equal-messages")
class TapsSomethingElse(LocalBackend):
    def add_tap(self, topic: str, on_message: Callable[[Any], object]) -> Tap:
        return super().add_tap(
            topic,
            lambda message: on_message(Imu() if isinstance(message, Imu) else message),
        )


@breaks("taps-hear-equal-messages")
class HasAnotherSchema(LocalBackend):
    def message_format(self, msg_type: Any) -> MessageFormat:
        return evolve(super().message_format(msg_type), schema="")


@breaks("closed-taps-are-silent")
class HearsOn(LocalBackend):
    def add_tap(self, topic: str, on_message: Callable[[Any], object]) -> Tap:
        tap = super().add_tap(topic, on_message)
        # `close` does nothing then.
        tap.is_closed = True
        return tap


@breaks("closed-taps-are-silent")
class ClosesAllTaps(LocalBackend):
    def add_tap(self, topic: str, on_message: Callable[[Any], object]) -> Tap:
        tap = super().add_tap(topic, on_message)
        tap._on_close = self._close_all
        return tap

    def _close_all(self, _tap: Tap) -> None:
        for tap in [*self._taps]:
            super()._remove_tap(tap)


@breaks("failing-taps-harm-nobody")
class RaisesWhatATapRaises(LocalBackend):
    def _fail_tap(self, tap: Tap, error: Exception) -> None:
        raise error


@breaks("failing-taps-harm-nobody")
class KeepsFailingTaps(LocalBackend):
    def _fail_tap(self, tap: Tap, error: Exception) -> None:
        tap._on_message = lambda message: self._again(tap, message)

    def _again(self, tap: Tap, message: Any) -> None:
        raise RuntimeError

    def add_tap(self, topic: str, on_message: Callable[[Any], object]) -> Tap:
        def hear(message: Any) -> None:
            try:
                on_message(message)
            except RuntimeError:
                return

        return super().add_tap(topic, hear)


@breaks("new-ends-are-told")
class TellsOfNothing(LocalBackend):
    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options)
        self.new_ends.tell = lambda describe: None  # type: ignore[method-assign]  # a mutant


@breaks("new-ends-are-told")
class TellsOfPublishersOnly(LocalBackend):
    def create_subscription(
        self, msg_type: Any, topic: Any, callback: Callable[[Any], object], qos_profile: Any
    ) -> Any:
        tell, self.new_ends.tell = self.new_ends.tell, lambda describe: None  # type: ignore[method-assign]  # a mutant
        try:
            return super().create_subscription(msg_type, topic, callback, qos_profile)
        finally:
            self.new_ends.tell = tell  # type: ignore[method-assign]  # as it was


@breaks("kept-messages-are-told")
class TellsOfNothingKept(LocalBackend):
    def kept_messages(self, topic: str) -> list[Any]:
        return super().kept_messages(topic)[:0]


@breaks("kept-messages-are-told")
class TellsOfWhatHasEnded(LocalBackend):
    def kept_messages(self, topic: str) -> list[Any]:
        self.known = super().kept_messages(topic) or getattr(self, "known", [])
        return self.known


@breaks("kept-messages-are-told")
class TellsBackwards(LocalBackend):
    def kept_messages(self, topic: str) -> list[Any]:
        return super().kept_messages(topic)[::-1]


@breaks("wrong-taps-are-errors")
class TapsAnyName(Changed):
    def add_tap(self, topic: str, on_message: Callable[[Any], object]) -> Tap:
        name = "".join(filter(str.isalnum, str(topic))) or "nameless"
        return super().add_tap(name, on_message)


@breaks("wrong-taps-are-errors")
class TapsWhenClosed(LocalBackend):
    def add_tap(self, topic: str, on_message: Callable[[Any], object]) -> Tap:
        try:
            return super().add_tap(topic, on_message)
        except BackendError:
            if not self._closed:
                raise
        return Tap(topic, on_message, print, print)


@breaks("graphs-tell-the-ends")
class ForgetsSubscriptions(LocalBackend):
    def graph(self) -> Graph:
        return evolve(super().graph(), subscriptions=())


@breaks("graphs-tell-the-ends")
class TellsOfOneNodeOnly(LocalBackend):
    def graph(self) -> Graph:
        self._owners.clear()
        return super().graph()


@breaks("graphs-tell-the-ends")
class RemembersWhatIsDestroyed(LocalBackend):
    def graph(self) -> Graph:
        graph = super().graph()
        self.known = dict.fromkeys((*getattr(self, "known", ()), *graph.publishers))
        return evolve(graph, publishers=tuple(self.known))


@breaks("graphs-tell-the-ends")
class HasNoClients(LocalBackend):
    def graph(self) -> Graph:
        return evolve(super().graph(), clients=())


@breaks("graphs-tell-the-ends")
class NamesClassesOfPython(LocalBackend):
    def graph(self) -> Graph:
        graph = super().graph()
        ends = [evolve(end, type_name=end.msg_type.__name__) for end in graph.publishers]
        return evolve(graph, publishers=tuple(ends))
