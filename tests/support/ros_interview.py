"""The questions that the tools of ROS put to a lifecycle node: `ros2` and launch."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from std_msgs.msg import String
from type_description_interfaces.srv import GetTypeDescription

from support.ros_twins import Asker, brief

Answers = Iterator[tuple[str, Any]]
Questions = Callable[[Asker], Iterable[tuple[str, Any]]]

LABELS = ["configure", "activate", "deactivate", "cleanup", "shutdown"]
PRIMARY = {
    "unconfigured": [],
    "inactive": ["configure"],
    "active": ["configure", "activate"],
    "finalized": ["shutdown"],
}


def change(asker: Asker, transition_id: int = 0, label: str = "") -> bool:
    """Ask for a transition; tell whether it was a success, when its events are here."""
    before = len(asker.events)
    wanted = Transition(id=transition_id, label=label)
    is_success = bool(asker.call(ChangeState, "change_state", transition=wanted).success)
    if is_success:
        await_events(asker, before)
    return is_success


def await_events(asker: Asker, before: int) -> None:
    """Wait for the events of a transition that has ended, all of them."""
    ends = {"unconfigured", "inactive", "active", "finalized"}
    asker.await_true(
        lambda: asker.events[before:] and asker.events[-1].goal_state.label in ends, "events"
    )


def meet(asker: Asker) -> None:
    """Have the node change its state until an event arrives: the first ones may be lost."""
    for label in ["configure", "cleanup"] * 20:
        call = asker.call(ChangeState, "change_state", transition=Transition(label=label))
        assert call.success
        if asker.events and label == "cleanup":
            break
    asker.await_true(lambda: asker.events, "events")
    asker.await_true(lambda: asker.events[-1].goal_state.label == "unconfigured", "last event")


def state(asker: Asker) -> str:
    """Return the label of the present state."""
    return str(asker.call(GetState, "get_state").current_state.label)


def available(asker: Asker) -> list[Any]:
    """Return the transitions that may be asked for."""
    found = asker.call(GetAvailableTransitions, "get_available_transitions")
    return [brief(item) for item in found.available_transitions]


def go_to(asker: Asker, goal: str) -> None:
    """Bring the node, which is unconfigured, into a primary state."""
    for label in PRIMARY[goal]:
        assert change(asker, label=label), label


def go_back(asker: Asker) -> None:
    """Bring it to unconfigured again."""
    for label in ("deactivate", "cleanup"):
        change(asker, label=label)


def lifecycle(asker: Asker) -> Answers:
    """What `ros2 lifecycle` and launch ask in every state, and what they are told of it."""
    meet(asker)
    yield "get_available_states", brief(asker.call(GetAvailableStates, "get_available_states"))
    yield "get_transition_graph", brief(asker.call(GetAvailableTransitions, "get_transition_graph"))
    for goal in ("unconfigured", "inactive", "active"):
        go_to(asker, goal)
        yield f"get_state, {goal}", brief(asker.call(GetState, "get_state"))
        yield f"get_available_transitions, {goal}", available(asker)
        for label in ("no such", "configure\n[INFO] [boss]: all is well\x1b[2J", "Configure"):
            yield f"change_state {label!r}, {goal}", change(asker, label=label)
        for label in LABELS:
            if label not in {item["transition"]["label"] for item in available(asker)}:
                yield f"change_state {label!r}, {goal}", change(asker, label=label)
        yield f"state after refusals, {goal}", state(asker)
        go_back(asker)
    yield "transitions by id", [change(asker, number) for number in (1, 3, 4, 2)]
    yield "a label beats an id", [change(asker, 3, "configure"), state(asker)]
    go_back(asker)


def outcomes(asker: Asker) -> Answers:
    """What is answered and published when a callback fails."""
    for answer in ("failure", "error", "raise", "success"):
        set_one(asker, "answer", answer)
        before = len(asker.events)
        yield f"configure, {answer}", change(asker, label="configure")
        yield f"state after {answer}", state(asker)
        await_events(asker, before)
        events = asker.events[before:]
        states = [brief([event.start_state, event.goal_state]) for event in events]
        yield f"states in the events, {answer}", states
        yield f"transitions in the events, {answer}", [e.transition.label for e in events]
    yield "timestamps of the events", "zero" if events[0].timestamp == 0 else "the time"
    go_back(asker)


def two_at_once(asker: Asker) -> Answers:
    """What is answered while a transition takes a second."""
    set_one(asker, "answer", "slow")
    yield (
        "get_state during a transition",
        meanwhile(asker, GetState, "get_state").current_state.label,
    )
    found = meanwhile(asker, GetAvailableTransitions, "get_available_transitions")
    labels = [item.transition.label for item in found.available_transitions]
    yield "get_available_transitions during a transition", labels
    second = Transition(label="activate")
    answer = meanwhile(asker, ChangeState, "change_state", transition=second)
    yield "change_state 'activate' during 'configure'", answer.success
    set_one(asker, "answer", "success")


def meanwhile(asker: Asker, kind: Any, service: str, **fields: Any) -> Any:
    """Return the response to a request that is sent while the node configures."""
    before = len(asker.events)
    first = asker.start(ChangeState, "change_state", transition=Transition(label="configure"))
    asker.await_true(lambda: asker.events[before:], "the beginning of the transition")
    second = asker.start(kind, service, **fields)
    assert asker.finish(first).success
    answer = asker.finish(second)
    await_events(asker, before)
    go_back(asker)
    return answer


def finalized(asker: Asker) -> Answers:
    """What is answered at the end of the life."""
    go_to(asker, "finalized")
    yield "get_state, finalized", state(asker)
    yield "get_available_transitions, finalized", available(asker)
    for label in ("configure", "shutdown"):
        yield f"change_state {label!r}, finalized", change(asker, label=label)


def value_of(value: Any) -> Any:
    """Return a value as ROS has it."""
    kinds = {
        bool: ("bool_value", ParameterType.PARAMETER_BOOL),
        int: ("integer_value", ParameterType.PARAMETER_INTEGER),
        float: ("double_value", ParameterType.PARAMETER_DOUBLE),
        str: ("string_value", ParameterType.PARAMETER_STRING),
    }
    if isinstance(value, list):
        field = "string_array_value" if isinstance(value[0], str) else "double_array_value"
        kind = ParameterType.PARAMETER_STRING_ARRAY
        kind = kind if isinstance(value[0], str) else ParameterType.PARAMETER_DOUBLE_ARRAY
        return ParameterValue(type=kind, **{field: value})
    field, kind = kinds[type(value)]
    return ParameterValue(type=kind, **{field: value})


def set_one(asker: Asker, name: str, value: Any) -> Any:
    """Set a parameter: what is answered."""
    given = [Parameter(name=name, value=value_of(value))]
    return brief(asker.call(SetParameters, "set_parameters", parameters=given).results[0])


def get(asker: Asker, *names: str) -> Any:
    """Return the values of parameters."""
    return brief(asker.call(GetParameters, "get_parameters", names=list(names)))


def parameters(asker: Asker) -> Answers:
    """What `ros2 param` asks."""
    for prefixes, depth in [
        ([], 0),
        ([], 1),
        (["motion"], 0),
        (["motion"], 1),
        (["motion"], 2),
        (["moti", "gains"], 0),
        (["use_sim_time"], 1),
    ]:
        found = asker.call(ListParameters, "list_parameters", prefixes=prefixes, depth=depth).result
        yield f"list_parameters {prefixes} {depth}", [sorted(found.names), sorted(found.prefixes)]
    names = ["answer", "motion.speed", "joints", "motion.is_soft", "gains", "names", "serial"]
    dynamic: list[bool] = []
    for name in [*names, "use_sim_time", "no.such"]:
        yield f"get_parameters {name}", get(asker, name)
        types = asker.call(GetParameterTypes, "get_parameter_types", names=[name])
        yield f"get_parameter_types {name}", brief(types)
        described = asker.call(DescribeParameters, "describe_parameters", names=[name])
        for descriptor in described.descriptors:
            dynamic.append(descriptor.dynamic_typing)
            descriptor.dynamic_typing = False
            yield f"describe_parameters {name}", brief(descriptor)
    yield "describe_parameters: dynamic_typing", str(any(dynamic)).lower()
    yield "get_parameters joints, no.such, answer", get(asker, "joints", "no.such", "answer")
    yield from settings(asker)


def settings(asker: Asker) -> Answers:
    """What `ros2 param set` and `ros2 param load` do."""
    good = [("motion.speed", 1.5), ("joints", 7), ("motion.is_soft", False), ("gains", [3.0])]
    for name, value in [*good, ("names", ["a", "b", "c"]), ("answer", "failure")]:
        asker.parameter_events.clear()
        yield f"set_parameters {name} {value}", set_one(asker, name, value)
        yield f"get_parameters {name} after {value}", get(asker, name)
        asker.await_true(lambda: asker.parameter_events, "event of a parameter")
        event = asker.parameter_events[0]
        yield f"event of {name} {value}", brief([event.node, event.changed_parameters])
    bad = [("motion.speed", 7.5), ("joints", 0), ("serial", "B2"), ("no.such", 1)]
    wrong = [("motion.speed", 1), ("joints", 7.5), ("answer", 5), ("gains", 1.0), ("joints", "x")]
    for name, value in [*bad, *wrong]:
        answer = set_one(asker, name, value)
        refusal = "refused" if answer.get("reason") else "refused without a reason"
        yield f"set_parameters {name} {value!r}", "set" if answer.get("successful") else refusal
        yield f"get_parameters {name} after {value!r}", get(asker, name)
    both = [("motion.speed", 1.0), ("joints", 0)]
    given = [Parameter(name=name, value=value_of(value)) for name, value in both]
    results = asker.call(SetParameters, "set_parameters", parameters=given).results
    yield "set_parameters, one good and one bad", [result.successful for result in results]
    yield "get_parameters after it", get(asker, "motion.speed", "joints")
    given[0].value.double_value = 0.25
    result = asker.call(SetParametersAtomically, "set_parameters_atomically", parameters=given)
    yield "set_parameters_atomically, one good and one bad", result.result.successful
    yield "get_parameters after that", get(asker, "motion.speed", "joints")
    set_one(asker, "answer", "success")


def graph(asker: Asker) -> Answers:
    """What `ros2 node info`, `ros2 topic info -v` and `ros2 service` show."""
    about = (asker.name, asker.namespace)
    node = asker.node
    found = node.get_node_names_and_namespaces_with_enclaves()
    yield "its name", [names for names in found if names[:2] == about]
    for what in ("publisher", "subscriber", "service", "client"):
        found = getattr(node, f"get_{what}_names_and_types_by_node")(*about)
        own = [[name.replace(asker.namespace, "", 1), *kinds] for name, kinds in found]
        yield f"its {what}s", sorted(own)
    for topic in ("joints", f"{asker.name}/transition_event", "/parameter_events", "/rosout"):
        full = topic if topic.startswith("/") else f"{asker.namespace}/{topic}"
        yield from ends(asker, "publisher", topic, node.get_publishers_info_by_topic(full))
    for topic in ("goal", "/clock"):
        full = topic if topic.startswith("/") else f"{asker.namespace}/{topic}"
        yield from ends(asker, "subscription", topic, node.get_subscriptions_info_by_topic(full))


def ends(asker: Asker, kind: str, topic: str, found: Any) -> Answers:
    """Give the node's ends of a topic with their quality of service."""
    own = [e for e in found if (e.node_name, e.node_namespace) == (asker.name, asker.namespace)]
    yield f"{kind}s of {topic}", len(own)
    for end in own[:1]:
        qos = end.qos_profile
        policies = [qos.reliability, qos.durability, qos.liveliness]
        times = [qos.deadline.nanoseconds, qos.lifespan.nanoseconds]
        named = [policy.name for policy in policies]
        yield f"{kind} of {topic}", [end.topic_type, *named, *times, str(end.topic_type_hash)]


def types(asker: Asker) -> Answers:
    """What `ros2 topic echo` asks of a type that it does not have."""
    (end,) = asker.node.get_publishers_info_by_topic(f"{asker.target}/transition_event")[:1]
    known = str(end.topic_type_hash)
    for name, type_hash in [
        ("lifecycle_msgs/msg/TransitionEvent", known),
        ("lifecycle_msgs/msg/TransitionEvent", "RIHS01_00"),
        ("no_msgs/msg/Such", known),
    ]:
        response = asker.call(
            GetTypeDescription,
            "get_type_description",
            type_name=name,
            type_hash=type_hash,
            include_type_sources=True,
        )
        yield f"get_type_description {name} {type_hash[:9]}", brief(response)


def samples(asker: Asker) -> Answers:
    """When what a node publishes comes out."""
    heard: list[Any] = []
    asker.node.create_subscription(String, f"{asker.namespace}/joints", heard.append, 10)
    asker.await_true(
        lambda: asker.node.get_subscriptions_info_by_topic(f"{asker.namespace}/joints"), "us"
    )
    for label in ("configure", "activate"):
        set_one(asker, "answer", "slow")
        yield f"joints before {label}", len(heard)
        change(asker, label=label)
    asker.await_true(lambda: heard, "joints")
    set_one(asker, "answer", "success")
    go_back(asker)


DEADLY: dict[str, dict[str, Any]] = {
    "change_state with an id that is not available": {"id": 3},
    "change_state with an unknown id": {"id": 99},
    "change_state with neither id nor label": {},
    "change_state with the id of an inner transition": {"id": 10},
}
"""Of these a node may die."""


def deadly(asker: Asker, question: str) -> Answers:
    """Ask for a transition: the answer, or the end of the node."""
    wanted = Transition(**DEADLY[question])
    future = asker.start(ChangeState, "change_state", transition=wanted)
    asker.await_true(lambda: future.done() or asker.has_ended, "an answer or an end")
    answer = (brief(future.result()) or "refused") if future.done() else "the node ends"
    yield question, answer


STARTS = [
    "-p motion.speed:=1.5 -p gains:=[4.0] -p serial:=B2 -p no.such:=1 -p other:joints:=3",
    *("-p motion.speed:=1", "-p motion.speed:=99.0", "-p joints:=7.5", "-p gains:=[4]"),
    "-p use_sim_time:=true -p start_type_description_service:=false",
    "-r __node:=left_arm -r joints:=/robot/joints -r goal:=~/goal -r ~/change_state:=change",
    "--enclave /robot --log-level debug --disable-rosout-logs -r other:goal:=g",
    *("--no-such", "-r nonsense", "--params-file /no/such.yaml"),
]
"""What launch and users give a node."""


def started(asker: Asker, given: str) -> Answers:
    """What a node is that has been given something."""
    if asker.has_ended:
        yield f"start, {given}", "the node ends"
        return
    yield f"start, {given}", "the node starts"
    names = ["answer", "motion.speed", "joints", "gains", "names", "serial", "use_sim_time"]
    yield f"parameters, {given}", get(asker, *names)
    found = dict(graph(asker))
    for question in ("its name", "its publishers", "its subscribers", "its services"):
        yield f"{question}, {given}", found[question]
    yield f"publishes /rosout, {given}", found["publishers of /rosout"] > 0


def everything(asker: Asker) -> Answers:
    """What one node can be asked in its life, in this order."""
    for topic in (graph, lifecycle, outcomes, parameters, types, samples, two_at_once, finalized):
        yield from topic(asker)
