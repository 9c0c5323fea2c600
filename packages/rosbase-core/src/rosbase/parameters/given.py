"""Values of parameters from outside the program, given before anybody has declared them.

A value is for one node (`camera.fps`, or the section of a node in a file), or for every node
(`fps`, or the section `/**`). Its declaration says its type. The values of a process are in
an environment variable, so its child processes have them too.
"""

import json
import os
import re
from collections.abc import Collection, Iterable, Sequence
from typing import Any, Literal

from attrs import define, evolve, field, frozen

from rosbase.errors import ConfigurationError, GivenParameterError, ParameterError
from rosbase.parameters.checking import did_you_mean
from rosbase.parameters.kinds import ParameterSpec, ParameterValue
from rosbase.parameters.written import WrittenText, from_outside, parse_text, parse_written

__all__ = [
    "GIVEN_VARIABLE",
    "LAUNCHED_VARIABLE",
    "GivenParameters",
    "GivenValue",
    "are_inherited",
    "given_parameters",
    "read_value",
    "values_of",
]

GIVEN_VARIABLE = "ROSBASE_PARAMETERS"
"""Environment variable with the values, as `GivenParameters.to_json` writes them."""

_ANY = ("", "/**", "**")
# Of a process that a manager has started.
_CHILD_MARK = "ROSBASE_CHILD_MARK"
LAUNCHED_VARIABLE = "ROSBASE_LAUNCHED"
"""Environment variable with the number of marks of a program that the launcher has started."""


@frozen
class GivenValue:
    """A value, not yet checked."""

    node: str
    """Name of the node, or a pattern with `*` and `**`; empty for every node."""
    name: str
    """Name of the parameter, possibly with the name of a node in front."""
    value: Any
    """Value: text, a value of JSON, or for "yaml" the items of a list or one item.

    An item is a text, or an object that says whether it was in quotes, and its bytes.
    """
    form: Literal["text", "typed", "yaml"]
    """Whether it was typed after `:=`, comes from TOML, or is written in YAML."""

    @property
    def text(self) -> str:
        """The value as text, without quotes."""
        return str(self.value["text"] if isinstance(self.value, dict) else self.value)


@define
class GivenParameters:
    """All values given to a process. Later ones win, and those for one node win over `/**`."""

    values: Sequence[GivenValue]
    _used: set[int] = field(init=False, factory=set)
    _declared: set[str] = field(init=False, factory=set)

    @classmethod
    def from_json(cls, text: str) -> "GivenParameters":
        """Read the text that `to_json` has written.

        Raises:
            ConfigurationError: It is another text.
        """
        try:
            return cls([GivenValue(*item) for item in json.loads(text)]) if text else cls([])
        except (TypeError, ValueError) as error:
            raise ConfigurationError(f"{GIVEN_VARIABLE} cannot be read: {error}") from error

    def to_json(self) -> str:
        """Return the values as text, for the environment."""
        values = [[v.node, v.name, v.value, v.form] for v in self.values]
        return json.dumps(values, separators=(",", ":"))

    def value_for(
        self, spec: ParameterSpec, names: Sequence[str], managers: Sequence[str] = ()
    ) -> ParameterValue | None:
        """Return the value that a parameter is given; None if there is none.

        Args:
            spec: The declaration, with the name as the node knows it.
            names: Names of the node, the one for messages first, possibly with a namespace.
            managers: Names of its manager, if it shares the connection of one.

        Raises:
            GivenParameterError: The value is not one of the declared type.
        """
        full = [f"{_base(name)}.{spec.name}" for name in names]
        self._declared.add(full[0])
        exact = [
            number
            for number, given in enumerate(self.values)
            if (given.name == spec.name and _is_section_of(given, names))
            or (given.name in full and (given.node in _ANY or _is_section_of(given, managers)))
        ]
        general = [
            number
            for number, given in enumerate(self.values)
            if given.name == spec.name and given.node in _ANY
        ]
        self._used.update(exact, general)
        last = max(exact or general, default=None)
        if last is None:
            return None
        try:
            return read_value(evolve(spec, name=full[0]), self.values[last])
        except ParameterError as error:
            raise GivenParameterError(str(error)) from error

    def unused(self, others: Collection[str] = (), *, only_for: str = "") -> list[str]:
        """Return a line for each value that no node has declared, each value once.

        Args:
            others: Names of nodes that may declare parameters elsewhere or later. If there are
                any, a value for every node may be for them.
            only_for: Name of the only node of which to tell; empty for all.
        """
        lines = []
        for number, given in enumerate(self.values):
            if number in self._used or any(_is_for(given, other) for other in others):
                continue
            if only_for and not _is_for(given, only_for):
                continue
            if others and given.node in _ANY and not self._names_a_node(given):
                continue
            self._used.add(number)
            name = given.name if given.node in _ANY else f"{given.node.strip('/')}.{given.name}"
            lines.append(f"no node declares the parameter {name}{self._hint(name)}")
        return lines

    def _names_a_node(self, given: GivenValue) -> bool:
        known = {full.partition(".")[0] for full in self._declared}
        return given.name.partition(".")[0] in known and "." in given.name

    def _hint(self, name: str) -> str:
        longer = sorted(one for one in self._declared if one.endswith(f".{name}"))
        if longer:
            return f"; did you mean {longer[0]}?"
        if hint := did_you_mean(name, self._declared):
            return hint
        return did_you_mean(name, {one.partition(".")[2] for one in self._declared})


def are_inherited() -> bool:
    """Return whether the values were given to the manager that has started this process.

    The launcher gives each program values of its own, although it marks it like a child.
    """
    marks = os.environ.get(_CHILD_MARK, "").split()
    launched = os.environ.get(LAUNCHED_VARIABLE, "")
    return len(marks) > (int(launched) if launched.isdecimal() else 0)


def given_parameters() -> GivenParameters:
    """Return the values given to this process, from its environment.

    Raises:
        ConfigurationError: The environment variable has another text.
    """
    text = os.environ.get(GIVEN_VARIABLE, "")
    if not _known or _known[0][0] != text:
        _known[:] = [(text, GivenParameters.from_json(text))]
    return _known[0][1]


_known: list[tuple[str, GivenParameters]] = []


def _is_for(given: GivenValue, node: str) -> bool:
    return _is_section_of(given, [node]) or given.name.startswith(f"{_base(node)}.")


def _is_section_of(given: GivenValue, names: Sequence[str]) -> bool:
    return given.node not in _ANY and any(_matches(given.node, name) for name in names)


def _base(name: str) -> str:
    """Return the name without its namespace."""
    return name.rpartition("/")[2]


def _matches(pattern: str, node: str) -> bool:
    """Return whether the pattern of a file has the node, as in rcl; `*` may be a part of a name.

    A pattern without a namespace has the node in any.
    """
    parts = pattern.strip("/").split("/")
    form = "".join(
        r"(/[^/]+)*" if part == "**" else "/" + "[^/]*".join(map(re.escape, part.split("*")))
        for part in parts
    )
    full = f"/{node.strip('/')}"
    return any(re.fullmatch(form, one) for one in {full, f"/{_base(full)}"})


def values_of(values: Iterable[GivenValue], node: str) -> dict[str, GivenValue]:
    """Return the values that a file has for a node, by name; its own win over `/**`."""
    values = list(values)
    general = {given.name: given for given in values if given.node in _ANY}
    return general | {given.name: given for given in values if _is_section_of(given, [node])}


def read_value(spec: ParameterSpec, given: GivenValue) -> ParameterValue:
    """Return a given value as the parameter takes it.

    Raises:
        ParameterError: It is not a value of the parameter's type.
    """
    if given.form == "text":
        return parse_text(spec, given.value)
    if given.form == "typed":
        return from_outside(spec, given.value)
    if isinstance(given.value, list):
        return parse_written(spec, tuple(_item(item) for item in given.value))
    return parse_written(spec, _item(given.value))


def _item(item: Any) -> WrittenText:
    if isinstance(item, str):
        return WrittenText(item)
    data = item.get("data")
    return WrittenText(item["text"], item["quoted"], None if data is None else bytes(data))
