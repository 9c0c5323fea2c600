"""Checks of parameters."""

import threading
from functools import partial
from itertools import starmap
from typing import Any

from rosbase.contracts.node_connection import NodeConnection
from rosbase.errors import ParameterError
from rosbase.parameters import (
    Parameter,
    ParameterKind,
    ParameterSpec,
    ParameterValue,
    SetParametersResult,
)
from rosbase.testing.backend_kit.promises import promise
from rosbase.testing.backend_kit.rig import BackendRig

__all__ = ["ParameterChecks"]

_NUMBERS, _TEXTS = ParameterKind.DOUBLE_ARRAY, ParameterKind.STRING_ARRAY
_SPECS = [
    ParameterSpec("flag", default=True),
    ParameterSpec("count", 7, "how many", minimum=1, maximum=9),
    ParameterSpec("rate", 1.5, "Hz", minimum=0.5),
    ParameterSpec("mode", "warn", choices=("warn", "off")),
    ParameterSpec("numbers", [1.0, 2.0], kind=_NUMBERS),
    ParameterSpec("no_numbers", [], kind=_NUMBERS),
    ParameterSpec("texts", ["a", "b"], kind=_TEXTS),
    ParameterSpec("no_texts", [], kind=_TEXTS),
    ParameterSpec("counts", [1, 2]),
    ParameterSpec("flags", [True, False]),
    ParameterSpec("octets", [b"a", b"b"]),
    ParameterSpec("no_octets", [], kind=ParameterKind.BYTE_ARRAY),
]
# Each value that is set, and the result.
_OVERRIDES: dict[str, tuple[ParameterValue, ParameterValue]] = {
    "flag": (False, False),
    "count": (3, 3),
    "rate": (5, 5.0),
    "mode": ("off", "off"),
    "numbers": ([0.5], [0.5]),
    "texts": (["c"], ["c"]),
    "no_texts": ([], []),
    "counts": ([3], [3]),
    "flags": ([], []),
    "octets": ([7], [b"\7"]),
}
_SET: dict[str, tuple[ParameterValue, ParameterValue]] = {
    **_OVERRIDES,
    "texts": ([], []),
    "counts": ([3], [3]),
    "flags": ([False], [False]),
    "no_numbers": ([1, 2.5], [1.0, 2.5]),
    "octets": ([], []),
    "no_octets": ([b"c"], [b"c"]),
}
_NEVER: list[Parameter[Any]] = [Parameter("serial", "B2"), Parameter("unheard_of", 1)]
_WRONG: dict[str, ParameterValue] = {
    "flag": 1,
    "count": 10,
    "rate": "fast",
    "mode": "loud",
    "numbers": ["a"],
    "octets": [256],
    "counts": [2**63],
}


class ParameterChecks(BackendRig):
    """Checks of declared parameters, and of values set from outside."""

    def test_parameters_keep_their_kind(self) -> None:
        promised, backend = promise("parameters-keep-their-kind"), self.open()
        for spec in _SPECS:
            declared = backend.declare_parameter(spec)
            for found in (declared, backend.get_parameter(spec.name)):
                promised.require(
                    found.name == spec.name and _same(found.value, spec.default),
                    f"{spec.default!r} became {found}",
                )

    def test_overrides_win(self) -> None:
        promised = promise("overrides-win")
        backend = self.open(parameters={name: value for name, (value, _) in _OVERRIDES.items()})
        for spec in _SPECS:
            if spec.name in _OVERRIDES:
                given, expected = _OVERRIDES[spec.name]
                declared = backend.declare_parameter(spec)
                for found in (declared, backend.get_parameter(spec.name)):
                    promised.require(
                        _same(found.value, expected), f"set to {given!r}, it became {found}"
                    )

    def test_wrong_overrides_are_errors(self) -> None:
        promised, backend = promise("wrong-overrides-are-errors"), self.open(parameters=_WRONG)
        for spec in _SPECS:
            if spec.name in _WRONG:
                doing = f"declaring {spec.name}, set to {_WRONG[spec.name]!r},"
                self.refuses(
                    promised,
                    ParameterError,
                    partial(backend.declare_parameter, spec),
                    doing,
                    spec.name,
                )
                self.refuses(
                    promised,
                    ParameterError,
                    partial(backend.get_parameter, spec.name),
                    "getting one whose override was wrong",
                )

    def test_declaring_twice_is_an_error(self) -> None:
        promised, backend = promise("declaring-twice-is-an-error"), self.open()
        backend.declare_parameter(ParameterSpec("rate", 1.0))
        self.refuses(
            promised,
            ParameterError,
            lambda: backend.declare_parameter(ParameterSpec("rate", 2.0)),
            "declaring rate again",
            "rate",
        )
        value = backend.get_parameter("rate").value
        promised.require(value == 1.0, f"declared twice, as 1.0 and 2.0, it became {value}")

    def test_setting_keeps_the_declared_kind(self) -> None:
        promised, backend = promise("setting-keeps-the-declared-kind"), self.open()
        for spec in _SPECS:
            backend.declare_parameter(spec)
        for name, (given, expected) in _SET.items():
            result = backend.set_parameters([Parameter(name, given)])
            promised.require(result.successful, f"{name} = {given!r} was refused: {result.reason}")
            found = backend.get_parameter(name).value
            promised.require(_same(found, expected), f"{name}, set to {given!r}, is {found!r}")

    def test_what_cannot_be_set_is_refused_whole(self) -> None:
        promised, backend = promise("what-cannot-be-set-is-refused-whole"), self.open()
        for spec in [*_SPECS, ParameterSpec("serial", "A1", read_only=True)]:
            backend.declare_parameter(spec)
        good = Parameter("rate", 2.5)
        wrongs: list[Parameter[Any]] = [*starmap(Parameter, _WRONG.items()), *_NEVER]
        for wrong in wrongs:
            if wrong.name == good.name:
                continue
            result = backend.set_parameters([good, wrong])
            is_told = wrong.name in result.reason and "\n" not in result.reason
            promised.require(not result.successful, f"{wrong} was set")
            promised.require(is_told, f"{wrong} was refused with {result.reason!r}")
            rate = backend.get_parameter("rate").value
            promised.require(rate == 1.5, f"{wrong} was refused, and what came with it was set")

    def test_a_callback_may_refuse_what_is_set(self) -> None:
        promised, backend = promise("a-callback-may-refuse-what-is-set"), self.open()
        backend.declare_parameter(ParameterSpec("rate", 1.5))
        asked: list[ParameterValue] = []

        def judge(parameters: list[Parameter[Any]]) -> SetParametersResult:
            asked.append(parameters[0].value)
            asked.append(backend.get_parameter("rate").value)
            return SetParametersResult(parameters[0].value != 5.0, "not five")

        backend.add_on_set_parameters_callback(judge)
        refused = backend.set_parameters([Parameter("rate", 5)])
        promised.require(asked == [5.0, 1.5], f"it was asked about, and saw, {asked}")
        is_told = not refused.successful and "not five" in refused.reason
        promised.require(is_told, f"what it refused ended as {refused}")
        promised.require(backend.get_parameter("rate").value == 1.5, "what it refused was set")
        promised.require(backend.set_parameters([Parameter("rate", 3)]).successful, "3 was refused")
        promised.require(backend.get_parameter("rate").value == 3.0, "3 was not set")

    def test_callbacks_hear_what_was_set(self) -> None:
        promised, backend = promise("callbacks-hear-what-was-set"), self.open()
        backend.declare_parameter(ParameterSpec("rate", 1.5))
        heard: list[tuple[ParameterValue, int]] = []
        backend.add_post_set_parameters_callback(
            lambda given: heard.extend((one.value, threading.get_ident()) for one in given)
        )
        backend.set_parameters([Parameter("rate", "fast")])
        backend.set_parameters([Parameter("rate", 3)])
        self.wait(promised, lambda: heard, lambda: "no callback was called", backend)
        expected = [(3.0, threading.get_ident())]
        promised.require(heard == expected, f"after rate was set to 3 it heard {heard}")

    def test_nodes_have_their_own_parameters(self) -> None:
        promised = promise("nodes-have-their-own-parameters")
        backend = self.open(parameters={"left.rate": 2.5, "rate": 3.5})
        asked: list[str] = []
        nodes: dict[str, NodeConnection] = {}
        for name, is_lifecycle in (("front", False), ("rear", False), ("left", True)):
            node = nodes[name] = backend.open_node(name, is_lifecycle=is_lifecycle)
            self.raises_nothing(
                promised,
                partial(node.declare_parameter, ParameterSpec("rate", 1.5)),
                f"declaring the parameter rate of the node {name}",
            )
            node.add_on_set_parameters_callback(partial(_note, asked, name))
        nodes["rear"].set_parameters([Parameter("rate", 4.5)])
        promised.require(asked == ["rear"], f"when rate of rear was set, it asked {asked}")
        found = {name: node.get_parameter("rate").value for name, node in nodes.items()}
        expected = {"front": 3.5, "rear": 4.5, "left": 2.5}
        promised.require(found == expected, f"they are {found}, and should be {expected}")

    def test_parameters_are_listed(self) -> None:
        promised, backend = promise("parameters-are-listed"), self.open()
        plain = backend.open_node("plain", is_lifecycle=False)
        camera = backend.open_node("camera", is_lifecycle=True)
        connections: dict[str, NodeConnection] = {"kit": backend, "plain": plain, "camera": camera}
        for connection in connections.values():
            connection.declare_parameter(ParameterSpec("zoom", 2, "times", minimum=1))
            connection.declare_parameter(ParameterSpec("exposure", 0.5))
        expected = {
            "kit": ["zoom", "exposure", "plain.zoom", "plain.exposure"],
            "plain": ["zoom", "exposure"],
            "camera": ["zoom", "exposure"],
        }
        for node, connection in connections.items():
            # A backend may have others of its own.
            names = [n for n in connection.parameter_names() if n.endswith(("zoom", "exposure"))]
            promised.require(names == expected[node], f"{node} listed {names}")
            spec = connection.describe_parameter("zoom")
            found = spec.name, spec.default, spec.description, spec.minimum
            promised.require(found == ("zoom", 2, "times", 1), f"{node} described zoom as {found}")
        self.refuses(
            promised,
            ParameterError,
            lambda: camera.describe_parameter("speed"),
            "describing speed, which was not declared,",
            "speed",
        )

    def test_undeclared_parameters_are_errors(self) -> None:
        promised, backend = promise("undeclared-parameters-are-errors"), self.open()
        self.refuses(
            promised,
            ParameterError,
            lambda: backend.get_parameter("rate"),
            "getting rate, which was not declared,",
            "rate",
        )


def _same(value: Any, expected: Any) -> bool:
    return type(value) is type(expected) and bool(value == expected)


def _note(asked: list[str], name: str, parameters: list[Parameter[Any]]) -> SetParametersResult:
    asked.append(name)
    return SetParametersResult(successful=True)
