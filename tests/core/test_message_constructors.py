"""Constructors of messages: what attrs' would do, in less time."""

import inspect
from typing import Any

import attrs
import pytest

from rosbase.messages import Imu, Vector3
from rosbase.messages.rcl_interfaces import ParameterDescriptor
from rosbase.wire.description import describe
from support.wire_messages import CLASSES, Rolled, made, name_of


def as_attrs_would(cls: Any) -> Any:
    """The same class, with the constructor of attrs."""
    fields = {
        one.name: attrs.field(default=one.default, validator=one.validator)
        for one in attrs.fields(cls)
    }
    return attrs.make_class(cls.__name__, fields, frozen=True, slots=True, eq=False)


@pytest.mark.parametrize("cls", CLASSES, ids=name_of)
def test_the_arguments_are_those_of_attrs(cls: Any) -> None:
    ours, theirs = inspect.signature(cls), inspect.signature(as_attrs_would(cls))
    assert [(one.name, one.kind) for one in ours.parameters.values()] == [
        (one.name, one.kind) for one in theirs.parameters.values()
    ]
    for name, one in ours.parameters.items():
        assert one.default is theirs.parameters[name].default
        assert one.annotation == attrs.fields_dict(cls)[name].type
    assert cls.__init__.__qualname__ == f"{cls.__name__}.__init__"


@pytest.mark.parametrize("cls", CLASSES, ids=name_of)
def test_the_fields_are_those_of_attrs(cls: Any) -> None:
    other, choose = as_attrs_would(cls), Rolled(1)
    for message in (cls(), *(made(describe(cls), choose) for _ in range(20))):
        values = {one.name: getattr(message, one.name) for one in attrs.fields(cls)}
        expected = other(**values)
        for found in (cls(**values), cls(*values.values())):
            assert type(found) is cls
            for name in values:
                assert getattr(found, name) is getattr(expected, name) or (
                    getattr(found, name) == getattr(expected, name)
                )


@pytest.mark.parametrize("cls", CLASSES, ids=name_of)
@pytest.mark.parametrize("wrong", [3, "three", [1.0], [0.0] * 9, None, (), b"", object()])
def test_a_value_that_attrs_refuses_or_replaces_is_refused_or_replaced(
    cls: Any, wrong: Any
) -> None:
    for one in attrs.fields(cls):
        results = []
        for kind in (cls, as_attrs_would(cls)):
            try:
                results.append(getattr(kind(**{one.name: wrong}), one.name))
            except (TypeError, ValueError) as error:
                results.append((type(error), str(error)))
        assert results[0] is results[1] or results[0] == results[1]


def test_validators_can_be_disabled_as_those_of_attrs() -> None:
    wrong: Any = (1.0,)
    with attrs.validators.disabled():
        assert Imu(orientation_covariance=wrong).orientation_covariance is wrong
    with pytest.raises(ValueError, match="orientation_covariance takes 9 elements, not 1"):
        Imu(orientation_covariance=wrong)


def test_a_message_cannot_be_changed_and_takes_no_unknown_field() -> None:
    with pytest.raises(attrs.exceptions.FrozenInstanceError):
        Vector3().x = 1.0  # type: ignore[misc]  # as said
    with pytest.raises(TypeError, match="unexpected keyword argument 'w'"):
        Vector3(w=1.0)  # type: ignore[call-arg]  # as said
    with pytest.raises(TypeError, match="positional arguments"):
        Vector3(1.0, 2.0, 3.0, 4.0)  # type: ignore[call-arg]  # as said


def test_a_field_may_be_named_like_a_function_of_python() -> None:
    assert ParameterDescriptor(type=3).type == 3
    assert attrs.evolve(Imu(), angular_velocity=Vector3(1.0)).angular_velocity.x == 1.0
