"""The answers of programs, as types. Only type checkers import this: at run time they are dicts."""

from typing import Any, TypedDict

__all__ = [
    "Child",
    "Count",
    "Endpoint",
    "Launched",
    "LifecycleState",
    "LogRecord",
    "NameAndType",
    "Node",
    "NodeInfo",
    "ParameterDescription",
    "Process",
    "Program",
    "QoS",
    "ServiceInfo",
    "SetResult",
    "Statistics",
    "Topic",
    "TransitionInfo",
    "TransitionResult",
    "Window",
]


class Child(TypedDict):
    """A child process of a manager."""

    name: str
    pid: int
    running: bool


class Program(TypedDict):
    """A manager, a lone node or a launcher."""

    name: str
    kind: str
    phase: str
    backend: str
    network: str
    state: Any
    waiting_for: list[str]
    rate_hz: float | None
    ticks: int
    overruns: int
    tick_ns: int | None
    up_ns: int
    nodes: list[str]
    children: list[Child]


class Process(TypedDict):
    """A process with a control socket."""

    pid: int
    command: list[str]
    name: str
    python: str
    rosbase: str
    started_ns: int
    cpu_ns: int
    memory_bytes: int
    threads: int
    programs: list[Program]
    clients: int
    dropped: int


class Node(TypedDict):
    """A node; several may share the name of their manager."""

    name: str
    pid: int
    program: str
    key: str
    lifecycle: str | None


class NameAndType(TypedDict):
    """A topic or a service of a node."""

    name: str
    type: str


class NodeInfo(TypedDict):
    """Topics, services and parameters of a node."""

    publishers: list[NameAndType]
    subscriptions: list[NameAndType]
    services: list[NameAndType]
    clients: list[NameAndType]
    parameters: int
    lifecycle: str | None


class QoS(TypedDict):
    """Quality of service of an end of a topic."""

    reliability: str
    durability: str
    history: str
    depth: int


class Endpoint(TypedDict):
    """A publisher or a subscription."""

    pid: int
    node: str
    qos: QoS
    dropped: int


class Topic(TypedDict):
    """A topic, with its ends in all programs."""

    name: str
    types: list[str]
    publishers: list[Endpoint]
    subscriptions: list[Endpoint]


class ServiceInfo(TypedDict):
    """A service, with the nodes that offer and call it."""

    name: str
    type: str
    pid: int
    servers: list[str]
    clients: list[str]


class Window(TypedDict, total=False):
    """Messages between two reports."""

    count: int
    seconds: float
    min_ns: int
    max_ns: int
    mean_ns: float
    std_ns: float
    bytes: int
    bytes_min: int
    bytes_max: int
    delay_count: int
    delay_min_ns: int
    delay_max_ns: int
    delay_mean_ns: float
    delay_std_ns: float


class Count(TypedDict):
    """A report on the messages of a topic."""

    n: int
    window: Window


class ParameterDescription(TypedDict, total=False):
    """Meaning of a parameter, and the values that it takes."""

    type: str
    description: str
    constraints: str
    read_only: bool
    range: list[float] | None
    change_time: str
    default: Any


class SetResult(TypedDict):
    """Whether a parameter was set."""

    successful: bool
    reason: str


class LifecycleState(TypedDict):
    """The state of a lifecycle node."""

    name: str
    pid: int
    state: str
    id: int


class TransitionInfo(TypedDict):
    """A transition that a node offers."""

    id: int
    label: str
    start: str
    goal: str


class TransitionResult(TypedDict):
    """Result of a transition."""

    successful: bool
    result: str
    state: str
    reason: str


class LogRecord(TypedDict):
    """A record of the log."""

    pid: int
    stamp_ns: int
    level: int
    name: str
    text: str


class Statistics(TypedDict, total=False):
    """The times of the ticks of a program."""

    pid: int
    program: str
    period: dict[str, Any]
    busy: dict[str, Any]
    ticks: int
    overruns: int
    tick_ns: int | None
    rate_hz: float | None


class Launched(TypedDict):
    """A program that `rosbase up` has started."""

    launcher: int
    name: str
    pid: int | None
    state: str
    restarts: int
    since_ns: int
    required: bool
    exit_status: int | None
