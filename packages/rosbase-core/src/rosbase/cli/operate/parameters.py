"""`rosbase param list`, `get`, `set`, `describe`, `dump` and `load`."""

from __future__ import annotations

import sys

from rosbase.cli.operate.message_text import harmless
from rosbase.cli.operate.reading import UsageError
from rosbase.control.questions.parameters import ParameterQuestions
from rosbase.errors import ConfigurationError, ControlError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from rosbase.control.shapes import SetResult

__all__ = ["describe", "dump", "load", "set_values", "show_list", "show_value"]

_LABELS = {
    "bool": "Boolean value is:",
    "integer": "Integer value is:",
    "double": "Double value is:",
    "string": "String value is:",
    "byte_array": "Byte values are:",
    "bool_array": "Boolean values are:",
    "integer_array": "Integer values are:",
    "double_array": "Double values are:",
    "string_array": "String values are:",
}
_TYPES = {"bool": "boolean", "bool_array": "boolean array", "not_set": "not set"}


def show_list(given: Any) -> None:
    """Print the names of parameters, by node, as `ros2 param list` does."""
    questions = ParameterQuestions(given.program)
    for node, names in questions.parameter_names(given.node).items():
        if given.node is None:
            print(f"{node}:")
        types = questions.typed_parameters(node, names) if given.param_type else {}
        for name in names:
            kind = f" (type: {_type(types[name]['type'])})" if name in types else ""
            print(f"  {name}{kind}")


def show_value(given: Any) -> None:
    """Print the value of a parameter, as `ros2 param get` does."""
    found = ParameterQuestions(given.program).typed_parameters(given.node, [given.parameter])
    one = found[given.parameter]
    label = _LABELS.get(one["type"])
    if label is None:
        print("Parameter not set.")
    elif given.hide_type:
        print(harmless(one["value"]))
    else:
        print(label, harmless(one["value"]))


def set_values(given: Any) -> int:
    """Set parameters, and print what became of each, as `ros2 param set` does."""
    words = given.name_and_value
    if len(words) % 2:
        raise UsageError("give names and values in turn: NAME VALUE [NAME VALUE ...]")
    try:
        " ".join(words).encode()
    except UnicodeEncodeError as error:
        raise UsageError("a name or a value is not UTF-8") from error
    values = {name: {"text": text} for name, text in zip(words[::2], words[1::2], strict=True)}
    questions = ParameterQuestions(given.program)
    results = questions.set_parameters(given.node, values, atomically=given.atomic)
    several = len(results) > 1
    failures = 0
    for name, result in results.items():
        words_for_it = "Set parameter successful", "Setting parameter failed"
        failures += _report(f"{name}: " if several else "", words_for_it, result)
    return 1 if failures else 0


def _report(head: str, texts: tuple[str, str], result: SetResult) -> bool:
    """Print what became of a parameter; return whether it was not set."""
    good, bad = texts
    reason = f": {result['reason']}" if result.get("reason") else ""
    if result["successful"]:
        print(f"{head}{good}{reason}")
    else:
        # Both streams keep the order of the parameters.
        sys.stdout.flush()
        print(f"{head}{bad}{reason}", file=sys.stderr)
    return not result["successful"]


def describe(given: Any) -> None:
    """Print what parameters mean, as `ros2 param describe` does."""
    questions = ParameterQuestions(given.program)
    found = questions.describe_parameters(given.node, given.parameters)
    for name, one in found.items():
        print(f"Parameter name: {name}\n  Type: {_type(one.get('type', 'not_set'))}")
        if one.get("description"):
            print(f"  Description: {one['description']}")
        print("  Constraints:")
        if one.get("read_only"):
            print("    Read only: true")
        if limits := one.get("range"):
            print(f"    Min value: {limits[0]}\n    Max value: {limits[1]}")
        if one.get("constraints"):
            print(f"    Additional constraints: {one['constraints']}")


def _type(kind: str) -> str:
    return _TYPES.get(kind, kind.replace("_", " "))


def dump(given: Any) -> None:
    """Print the parameters of a node as a parameter file of ROS 2."""
    from rosbase.text.yaml_text import as_yaml

    questions = ParameterQuestions(given.program)
    nested: dict[str, Any] = {}
    for name, one in sorted(questions.typed_parameters(given.node).items()):
        if one["value"] is not None:
            _insert(nested, name, one["value"])
    (full, *_), _ = questions.names_in_files(given.node)
    print(as_yaml({full: {"ros__parameters": nested}}, sort_keys=True))


def _insert(nested: dict[str, Any], name: str, value: Any) -> None:
    """Put a value in the tree of dotted names; a name that is also a group stays as it is."""
    head, dot, rest = name.partition(".")
    group = nested.setdefault(head, {}) if dot else None
    if isinstance(group, dict):
        _insert(group, rest, value)
    else:
        nested[name] = value


def load(given: Any) -> int:
    """Set the parameters that a file has for a node, as `ros2 param load` does."""
    from rosbase.cli.operate.parameter_files import values_in

    questions = ParameterQuestions(given.program)
    names, managers = questions.names_in_files(given.node)
    known = questions.typed_parameters(given.node)
    described = questions.describe_parameters(given.node, known)
    types = {name: one["type"] for name, one in known.items()}
    wildcards = not given.no_use_wildcard
    try:
        values, unknown = values_in(given.file, names, managers, types, wildcards=wildcards)
    except ConfigurationError as error:
        raise UsageError(str(error)) from error
    if not values and not unknown:
        raise ControlError(f"{given.file} has no parameters for {names[0]}", "unknown")
    # What `param dump` prints has read-only parameters too, which have that value already.
    values = {
        name: value
        for name, value in values.items()
        if not (described[name].get("read_only") and known[name]["value"] == value)
    }
    results = questions.set_parameters(given.node, values) if values else {}
    failures = len(unknown)
    for name, result in sorted(results.items()):
        texts = f"Set parameter {name} successful", f"Set parameter {name} failed"
        failures += _report("", texts, result)
    for line in unknown:
        print(f"rosbase: {line}", file=sys.stderr)
    return 1 if failures else 0
