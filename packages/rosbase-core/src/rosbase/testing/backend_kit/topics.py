"""Checks of topics: names, types, messages and delivery."""

from functools import partial
from typing import Any

from attrs import asdict, evolve

from rosbase.contracts.backend import Backend
from rosbase.errors import BackendError
from rosbase.messages import (
    Bool,
    DiagnosticArray,
    DiagnosticStatus,
    Header,
    Imu,
    JointState,
    Joy,
    KeyValue,
    MagneticField,
    Point,
    PointStamped,
    Pose,
    PoseStamped,
    Quaternion,
    String,
    Time,
    Twist,
    Vector3,
)
from rosbase.testing.backend_kit.promises import promise
from rosbase.testing.backend_kit.rig import BackendRig, Listener
from rosbase.testing.promise import Promise

__all__ = ["TopicChecks"]

_NO_NAMES: tuple[Any, ...] = (
    *("", "/", "a//b", "1a", "a/1", "a b", " ", "a/", "a.b", "a-b", "ä", 5),
    *("~a", "a/~", "{a}", "{node"),
)
_KINDS: tuple[type, ...] = (
    *(Bool, DiagnosticArray, DiagnosticStatus, Header, Imu, JointState, Joy, KeyValue),
    *(MagneticField, Point, PointStamped, Pose, PoseStamped, Quaternion, String, Time),
    *(Twist, Vector3),
)
_VARYING = ("header.stamp", "orientation", "angular_velocity", "linear_acceleration")
_TEMPLATE = Imu(
    Header(frame_id="imu_link"),
    orientation_covariance=(0.1, 0.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 0.3),
    angular_velocity_covariance=(1.0,) * 9,
    linear_acceleration_covariance=(-1.0, *(0.0,) * 8),
)
_SAMPLE = (7_000_000_005, (0.0, 0.6, 0.0, 0.8), (0.1, -0.2, 0.3), (0.0, 1.5, -9.81))


class TopicChecks(BackendRig):
    """Checks that messages reach subscriptions unaltered."""

    def test_every_subscription_hears(self) -> None:
        promised, backend = promise("every-subscription-hears"), self.open()
        talker = self.talker(backend)
        listeners = [
            self.listener(backend),
            self.listener(backend),
            Listener(backend, f"/{self.topic}", 10),
        ]
        self.connect(promised, talker, *listeners)
        talker.say(1, 2, 3)
        self.settle(promised, talker, *listeners)
        heard = [listener.numbers for listener in listeners]
        promised.require(heard == [[1, 2, 3]] * 3, f"of 1, 2, 3 three subscriptions heard {heard}")

    def test_messages_arrive_equal(self) -> None:
        promised, backend = promise("messages-arrive-equal"), self.open()
        full = _sent_as_message(backend.clock.now())
        for number, sent in enumerate([*(kind() for kind in _KINDS), full, String("ä\n€")]):
            topic = f"{self.topic}_{number}"
            got = self._exchange(promised, backend, topic, sent)
            promised.require(got == sent, _difference(got, sent))

    def test_names_are_full(self) -> None:
        promised, backend = promise("names-are-full"), self.open()
        space, _, name = f"/{backend.node_name}".rpartition("/")
        for topic, full in {
            self.topic: f"{space}/{self.topic}",
            f"/a/{self.topic}": f"/a/{self.topic}",
            f"~/{self.topic}": f"{space}/{name}/{self.topic}",
        }.items():
            for end in (
                backend.create_publisher(String, topic, 1),
                backend.create_subscription(String, topic, print, 1),
            ):
                promised.require(end.topic == full, f"{topic!r} is shown as {end.topic!r}")

    def test_wrong_names_are_errors(self) -> None:
        promised, backend = promise("wrong-names-are-errors"), self.open()
        for name in _NO_NAMES:
            doing, shown = f"a topic called {name!r}", repr(name)
            self._refuses_topic(promised, backend, String, name, doing, shown)

    def test_wrong_types_are_errors(self) -> None:
        promised, backend = promise("wrong-types-are-errors"), self.open()
        talker = self.talker(backend)
        doing = "a topic of Vector3 used for String"
        self._refuses_topic(promised, backend, String, self.topic, doing, self.topic)
        listener = self.listener(backend)
        self.connect(promised, talker, listener)

    def test_wrong_messages_are_errors(self) -> None:
        promised, backend = promise("wrong-messages-are-errors"), self.open()
        talker, listener = self.talker(backend), self.listener(backend)
        self.connect(promised, talker, listener)
        before = len(listener.heard)
        wrongs: tuple[Any, ...] = (Time(), None, "words")
        for wrong in wrongs:
            self.refuses(
                promised,
                TypeError,
                partial(talker.publisher.publish, wrong),
                f"publishing {wrong!r} on a topic of Vector3",
                self.topic,
            )
        template: Any = Imu()
        self.refuses(
            promised,
            TypeError,
            lambda: backend.prepared_sender(talker.publisher, template, ["header.stamp"])(1),
            "a prepared sender of an Imu on a topic of Vector3",
            self.topic,
        )
        self.settle(promised, talker, listener)
        promised.require(len(listener.heard) == before + 1, "a wrong message has arrived")

    def test_samples_arrive_like_messages(self) -> None:
        promised, backend = promise("samples-arrive-like-messages"), self.open()
        publisher = backend.create_publisher(Imu, self.topic, 10)
        got: list[Imu] = []
        backend.create_subscription(Imu, self.topic, got.append, 10)
        send = backend.prepared_sender(publisher, _TEMPLATE, _VARYING)
        self.wait(
            promised,
            lambda: got,
            lambda: "no sample has arrived",
            backend,
            meanwhile=lambda: send(*_SAMPLE),
        )
        expected = _sent_as_message(Time.from_nanoseconds(_SAMPLE[0]))
        promised.require(got[0] == expected, _difference(got[0], expected))

    def test_delivers_in_process(self) -> None:
        promised, backend = promise("delivers-in-process"), self.open()
        says = backend.delivers_in_process
        declared = self.capabilities.delivers_in_process
        promised.require(says == declared, f"it is {says}, and declared as {declared}")
        self.needs("delivers_in_process")
        got: list[Vector3] = []
        backend.create_subscription(Vector3, self.topic, got.append, 1)
        sent = Vector3(1.0)
        backend.create_publisher(Vector3, self.topic, 1).publish(sent)
        backend.spin_once(0.0)
        promised.require(got, "the message did not wait for the callback when publish returned")
        promised.require(got[0] is sent, "the message is a copy")

    def test_backends_hear_each_other(self) -> None:
        self.needs("several_per_process")
        promised, backend, peer = promise("backends-hear-each-other"), self.open(), self.open_peer()
        listeners = self.listener(backend), self.listener(peer)
        for number, one in enumerate((backend, peer)):
            talker = self.talker(one)
            self.connect(promised, talker, *listeners)
            talker.say(number)
            self.settle(promised, talker, *listeners)
        heard = [listener.numbers for listener in listeners]
        promised.require(heard == [[0, 1]] * 2, f"of 0 and 1, one from each, they heard {heard}")

    def _exchange(self, promised: Promise, backend: Backend, topic: str, sent: Any) -> Any:
        """Return the message that arrives when it is sent."""
        got: list[Any] = []
        publisher = backend.create_publisher(type(sent), topic, 10)
        backend.create_subscription(type(sent), topic, got.append, 10)
        self.wait(
            promised,
            lambda: got,
            lambda: f"no {type(sent).__name__} has arrived",
            backend,
            meanwhile=lambda: publisher.publish(sent),
        )
        return got[0]

    def _refuses_topic(
        self, promised: Promise, backend: Backend, kind: type, name: Any, doing: str, shown: str
    ) -> None:
        for what, create in {
            "a publisher": lambda: backend.create_publisher(kind, name, 1),
            "a subscription": lambda: backend.create_subscription(kind, name, print, 1),
        }.items():
            self.refuses(promised, BackendError, create, f"{what} of {doing}", shown)


def _difference(got: Any, sent: Any) -> str:
    """Describe the fields of a message that are wrong."""
    changed = [
        f"{name} became {getattr(got, name, None)!r}, not {value!r}"
        for name, value in asdict(sent, recurse=False).items()
        if getattr(got, name, None) != value
    ]
    return f"a message of {type(sent)} came as {type(got)}: {'; '.join(changed)}"


def _sent_as_message(stamp: Time) -> Imu:
    """Return the sample as a message."""
    _, turned, rate, force = _SAMPLE
    return evolve(
        _TEMPLATE,
        header=Header(stamp, _TEMPLATE.header.frame_id),
        orientation=Quaternion(*turned),
        angular_velocity=Vector3(*rate),
        linear_acceleration=Vector3(*force),
    )
