"""Explain why decoded JSON is no sample: paths that lead nowhere, and texts for numbers."""

import re
from collections.abc import Mapping, Sequence
from typing import TypeAlias

from attrs import frozen

from rosbase.imu.diagnosis.cause import Cause, shown
from rosbase.imu.diagnosis.places import Lost, diagnose_path, follow
from rosbase.imu.mapping import GROUPS, VECTORS, ImuMapping
from rosbase.imu.rejects import meaning_of
from rosbase.mapping.path_text import parse_path
from rosbase.mapping.paths import Steps
from rosbase.mapping.rejects import Reject

__all__ = ["Mapped", "diagnose_payload", "mapped_by"]

_Paths: TypeAlias = Mapping[str, Sequence[Steps]]

_NUMBER = r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?"
_PLAIN = re.compile(rf"\s?{_NUMBER}\s?")
_COMMA = re.compile(r"\s?[-+]?\d+,\d+\s?\S{0,8}")
_WITH_UNIT = re.compile(rf"\s?{_NUMBER}\s?[^\s\d.,+-][^\s]{{0,11}}\s?")
_NO_READING = re.compile(
    r"\s?(n/?a|nan|inf|null|none|err(or)?|-+|unknown|unavailable|overflow)?\s?", re.I
)


@frozen
class Mapped:
    """Places that a mapping reads, and its sentinels."""

    paths: _Paths
    """Steps to the components of a quantity, or to a list of them; most important first."""
    sentinels: frozenset[float] = frozenset()
    """Numbers that mean that there is no reading."""


def mapped_by(mapping: ImuMapping) -> Mapped:
    """Return the places that a mapping reads; of alternatives, the first."""
    # Few payloads have an orientation.
    ordered = sorted(
        GROUPS, key=lambda group: (group not in mapping.required, group not in VECTORS)
    )
    texts: dict[str, tuple[str, ...]] = {
        group: getattr(mapping, f"{group}_paths") for group in ordered
    }
    texts_count = mapping.numeric_strings
    steps = {
        group: [parse_path(path, numeric_strings=texts_count)[0].steps for path in paths]
        for group, paths in texts.items()
    }
    return Mapped(steps, frozenset(mapping.sentinels))


def diagnose_payload(payload: object, reject: Reject, mapped: Mapped) -> Cause | None:
    """Return why a mapping finds no sample in a payload, if that can be found out. Never raises.

    Args:
        payload: Payload of the frame.
        reject: Reason of the refusal.
        mapped: Places that the mapping reads.
    """
    # A detail begins with the quantity.
    quantity = re.split("[: ]", reject.detail)[0]
    paths = mapped.paths
    looked = {quantity: paths[quantity]} if quantity in paths else paths
    if reject.reason == "wrong_type":
        odd = [(name, _odd_value(payload, steps)) for name, steps in looked.items()]
        return next((Cause(f"{name}: {said}") for name, said in odd if said), None)
    lost = [
        (name, found)
        for name, many in looked.items()
        for found in [diagnose_path(payload, steps) for steps in many]
        if found
    ]
    # Where several lead nowhere, one of which it is known what was meant tells more.
    lost.sort(key=lambda item: not item[1].has_hint)
    if lost:
        return _lost_cause(reject, *lost[0])
    found = ((name, follow(payload, steps)[0]) for name, many in looked.items() for steps in many)
    return next((c for name, value in found if (c := _no_reading(name, value, mapped))), None)


def _no_reading(name: str, value: object, mapped: Mapped) -> Cause | None:
    """Return whether a quantity is absent because one of its numbers means so."""
    for one in value if isinstance(value, list) else [value]:
        if isinstance(one, (int, float)) and one in mapped.sentinels:
            return Cause(f"{name}: {one} means that there is no reading (mapping.sentinels)")
    return None


def _lost_cause(reject: Reject, name: str, lost: Lost) -> Cause | None:
    if reject.reason == "incomplete":
        # What is lacking is known.
        return Cause(f"{reject.detail}: {lost.text}") if lost.has_hint else None
    known = "" if lost.has_hint or reject.detail else f"{meaning_of(reject.reason)} "
    return Cause(f"{known}{name}: {lost.text}")


def _odd_value(payload: object, paths: Sequence[Steps]) -> str:
    for steps in paths:
        value, number = follow(payload, steps)
        if number < len(steps):
            continue
        for one in value if isinstance(value, list) else [value]:
            if isinstance(one, str):
                return _text_for_number(one)
        if isinstance(value, list) and len(paths) == 1:
            return _odd_list(value)
    return ""


def _text_for_number(text: str) -> str:
    if _PLAIN.fullmatch(text):
        return f"{shown(text)} is a number in quotes: set mapping.numeric_strings to true"
    if _COMMA.fullmatch(text):
        return f"{shown(text)} has a decimal comma; the device must print a point"
    if _WITH_UNIT.fullmatch(text):
        return f"{shown(text)} is a number with its unit; the device must send the number alone"
    if _NO_READING.fullmatch(text):
        return f"{shown(text)} in place of a number: the device has no reading"
    return f"the text {shown(text)} in place of a number"


def _odd_list(values: list[object]) -> str:
    are_whole = all(isinstance(value, int) for value in values)
    if are_whole and len(values) in (6, 8):
        return f"a list of {len(values)} whole numbers; are they decimals with a comma?"
    return f"a list of {len(values)}"
