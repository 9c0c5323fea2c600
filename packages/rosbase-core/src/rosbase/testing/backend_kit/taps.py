"""Checks of taps, of the graph, and of the formats of messages."""

from typing import Any, TypeAlias

from rosbase.contracts.backend import Backend
from rosbase.contracts.graph import ServiceEnd, TopicEnd
from rosbase.errors import BackendError
from rosbase.messages import Imu, Vector3
from rosbase.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbase.testing.backend_kit.promises import promise
from rosbase.testing.backend_kit.rig import BackendRig, Listener
from rosbase.testing.promise import Promise

__all__ = ["TapChecks"]

_VECTOR3 = "geometry_msgs/msg/Vector3"
_LATCHED = QoSProfile(3, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_BEST_EFFORT = QoSProfile(7, reliability=ReliabilityPolicy.BEST_EFFORT)


class _Ear:
    """A tap that notes numbers."""

    def __init__(self, backend: Backend, topic: str) -> None:
        self._decode = backend.message_format(Vector3).decode
        self.heard: list[int] = []
        self.tap = backend.add_tap(topic, self._hear)

    @property
    def numbers(self) -> list[int]:
        """The numbers heard, without marks."""
        return [number for number in self.heard if number >= 0]

    def _hear(self, message: Any) -> None:
        if isinstance(message, bytes):
            message = self._decode(message)
        self.heard.append(int(message.x))


class TapChecks(BackendRig):
    """Checks that taps hear everything and change nothing."""

    def test_taps_hear_what_is_published(self) -> None:
        promised, backend = self._tapped("taps-hear-what-is-published")
        early, latched = self.talker(backend), self.talker(backend, _LATCHED)
        ears = _Ear(backend, self.topic), _Ear(backend, f"/{self.topic}")
        later = self.talker(backend)
        early.say(1)
        later.say(2)
        latched.say(3)
        listener = self.listener(backend)
        self.connect(promised, early, listener)
        for talker in (early, latched, later):
            send = backend.prepared_sender(talker.publisher, Vector3(), ["x"])
            send(4.0)
            talker.say(5)
        heard = [ear.numbers for ear in ears]
        self._require_numbers(promised, heard, [[1, 2, 3, 4, 5, 4, 5, 4, 5]] * 2)
        # What comes back from outside has been heard.
        self.settle(promised, early, listener)
        self._require_numbers(promised, [ear.numbers for ear in ears], heard)

    def test_taps_hear_what_arrives(self) -> None:
        self.needs("several_per_process")
        promised, backend = self._tapped("taps-hear-what-arrives")
        talker = self.talker(self.open_peer())
        listeners = [
            self.listener(backend),
            self.listener(backend, _BEST_EFFORT),
            self.listener(backend),
        ]
        self.connect(promised, talker, *listeners)
        ear = _Ear(backend, self.topic)
        talker.say(1, 2, 3)
        self.settle(promised, talker, *listeners)
        self._require_numbers(promised, [ear.numbers], [[1, 2, 3]])

    def test_taps_hear_equal_messages(self) -> None:
        promised, backend = self._tapped("taps-hear-equal-messages")
        form, heard = backend.message_format(Imu), list[Any]()
        publisher = backend.create_publisher(Imu, self.topic, 10)
        backend.add_tap(self.topic, heard.append)
        sent = Imu(angular_velocity=Vector3(1.0, 2.0, 3.0))
        publisher.publish(sent)
        promised.require(len(heard) == 1, f"of one message, {len(heard)} were heard")
        got = form.decode(heard[0]) if isinstance(heard[0], bytes) else heard[0]
        promised.require(got == sent, f"{sent!r} was heard as {got!r}")
        promised.require(
            form.decode(form.encode(sent)) == sent, "a message does not survive its format"
        )
        promised.require(
            form.type_name == "sensor_msgs/msg/Imu" and "frame_id" in form.schema,
            f"the format of Imu is called {form.type_name!r}, with the schema {form.schema!r}",
        )

    def test_closed_taps_are_silent(self) -> None:
        promised, backend = self._tapped("closed-taps-are-silent")
        talker, left = self.talker(backend), _Ear(backend, self.topic)
        ear = _Ear(backend, self.topic)
        talker.say(1)
        ear.tap.close()
        talker.say(2)
        self.talker(backend).say(3)
        self._require_numbers(promised, [ear.numbers, left.numbers], [[1], [1, 2, 3]])
        self.raises_nothing(promised, ear.tap.close, "closing a tap twice")
        backend.close()
        self.raises_nothing(promised, left.tap.close, "closing a tap after its backend")
        self.raises_nothing(promised, lambda: talker.say(4), "publishing after that")
        self._require_numbers(promised, [left.numbers], [[1, 2, 3]])

    def test_failing_taps_harm_nobody(self) -> None:
        promised, backend = self._tapped("failing-taps-harm-nobody")
        talker, listener = self.talker(backend), self.listener(backend)
        self.connect(promised, talker, listener)
        calls: list[Any] = []

        def fail(message: Any) -> None:
            calls.append(message)
            raise RuntimeError("a tap of the kit")

        backend.add_tap(self.topic, fail)
        ear = _Ear(backend, self.topic)
        self.raises_nothing(promised, lambda: talker.say(1, 2), "publishing to a tap that raises")
        self.settle(promised, talker, listener)
        talker.say(3)
        self.settle(promised, talker, listener)
        self._require_numbers(promised, [listener.numbers, ear.numbers], [[1, 2, 3]] * 2)
        promised.require(len(calls) == 1, f"a tap that raises was called {len(calls)} times")

    def test_kept_messages_are_told(self) -> None:
        promised, backend = self._tapped("kept-messages-are-told")
        decode = backend.message_format(Vector3).decode

        def kept() -> list[int]:
            found = backend.kept_messages(self.topic)
            messages = [decode(one) if isinstance(one, bytes) else one for one in found]
            return [int(message.x) for message in messages]

        talker, volatile = self.talker(backend, _LATCHED), self.talker(backend)
        send = backend.prepared_sender(talker.publisher, Vector3(), ["x"])
        self._require_numbers(promised, [kept()], [[]])
        talker.say(1, 2)
        volatile.say(7)
        self._require_numbers(promised, [kept()], [[1, 2]])
        talker.say(3)
        send(4.0)
        self._require_numbers(promised, [kept()], [[2, 3, 4]])
        backend.destroy_publisher(talker.publisher)
        self._require_numbers(promised, [kept()], [[]])

    def test_new_ends_are_told(self) -> None:
        promised, backend = self._tapped("new-ends-are-told")
        told: list[TopicEnd] = []
        ears: list[_Ear] = []

        def welcome(end: TopicEnd) -> None:
            told.append(end)
            ears.append(_Ear(backend, end.name))

        backend.new_ends.add(welcome)
        talker = self.talker(backend)
        talker.say(1)
        listener = Listener(backend, f"{self.topic}_heard", _BEST_EFFORT)
        backend.new_ends.remove(welcome)
        self.talker(backend)
        own = [(end.name, end.type_name) for end in told]
        names = [talker.publisher.topic, listener.subscription.topic]
        promised.require(
            own == [(name, _VECTOR3) for name in names],
            f"of the topics {names}, {own} were told",
        )
        self._require_numbers(promised, [ears[0].numbers], [[1]])

    def test_wrong_taps_are_errors(self) -> None:
        promised, backend = self._tapped("wrong-taps-are-errors")
        for name in ("", "a//b", "a b", 5):
            self._refuses_tap(promised, backend, name, repr(name))
        backend.close()
        self._refuses_tap(promised, backend, self.topic, "")

    def test_graphs_tell_the_ends(self) -> None:
        promised, backend = self._tapped("graphs-tell-the-ends")
        node = f"/{backend.node_name}"
        inner = backend.open_node("inner", is_lifecycle=True)
        publisher = backend.create_publisher(Vector3, self.topic, _LATCHED)
        listener = Listener(backend, f"{self.topic}_heard", _BEST_EFFORT)
        inner_publisher = inner.create_publisher(Vector3, "~/point", 10)
        subscription, other = listener.subscription, f"/{inner.node_name}"
        expected: list[tuple[str, _Facts, QoSProfile | None]] = [
            ("publishers", (node, publisher.topic, _VECTOR3), _LATCHED),
            ("subscriptions", (node, subscription.topic, _VECTOR3), _BEST_EFFORT),
            ("publishers", (other, inner_publisher.topic, _VECTOR3), QoSProfile()),
        ]
        if self.capabilities.has_services:
            kind = self.service_kind.srv_type
            service = backend.create_service(kind, self.topic, lambda request: None)
            client = inner.create_client(kind, f"{self.topic}_asked")
            expected += [
                ("services", (node, service.service_name, None), None),
                ("clients", (other, client.service_name, None), None),
            ]
        for ends, facts, profile in expected:
            self._wait_for_end(promised, backend, ends, facts, profile)
        nodes = backend.graph().nodes
        promised.require({node, other} <= {*nodes}, f"the nodes of the graph are {nodes}")
        backend.destroy_publisher(publisher)
        backend.destroy_subscription(subscription)
        for ends, facts, _ in expected[:2]:
            self._wait_for_no_end(promised, backend, ends, facts)

    def _tapped(self, name: str) -> tuple[Promise, Backend]:
        self.needs("has_taps")
        return promise(name), self.open()

    def _wait_for_end(
        self,
        promised: Promise,
        backend: Backend,
        ends: str,
        facts: "_Facts",
        profile: QoSProfile | None,
    ) -> None:
        def is_there() -> bool:
            found = _found(getattr(backend.graph(), ends), facts)
            return any(profile is None or _offers(end, profile) for end in found)

        def seen() -> str:
            return f"{facts} with {profile} is not among {getattr(backend.graph(), ends)}"

        self.wait(promised, is_there, seen, backend)

    def _wait_for_no_end(
        self, promised: Promise, backend: Backend, ends: str, facts: "_Facts"
    ) -> None:
        def is_gone() -> bool:
            return not _found(getattr(backend.graph(), ends), facts)

        self.wait(
            promised,
            is_gone,
            lambda: f"{facts} is among the {ends} though it was destroyed",
            backend,
        )

    def _refuses_tap(self, promised: Promise, backend: Backend, name: Any, shown: str) -> None:
        doing = f"a tap of {name!r}"
        self.refuses(promised, BackendError, lambda: backend.add_tap(name, print), doing, shown)

    def _require_numbers(
        self, promised: Promise, heard: list[list[int]], expected: list[list[int]]
    ) -> None:
        promised.require(heard == expected, f"{heard} was heard, not {expected}")


_Facts: TypeAlias = tuple[str, str, str | None]
"""The node, the name and the type of an end; without a type, of any."""


def _found(ends: tuple[TopicEnd | ServiceEnd, ...], facts: _Facts) -> list[Any]:
    """Return the ends with these facts."""
    node, name, kind = facts
    return [
        end
        for end in ends
        if (end.node, end.name) == (node, name) and kind in (None, end.type_name)
    ]


def _offers(end: TopicEnd, profile: QoSProfile) -> bool:
    """Return whether the policies that matter to matching equal the profile's."""
    found = end.profile
    return found is not None and (found.durability, found.reliability) == (
        profile.durability,
        profile.reliability,
    )
