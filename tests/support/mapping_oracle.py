"""What a mapping makes of a payload, by docs/mapping.md: slow, and so plain that it can be seen.

It shares no code with rosbase: it follows each component of each sample alone, from the top of
the payload, and knows of no usual case. `read` gives what the compiled reader should,
with the reason in place of each refusal:

    "no_imu_data"                                  refused
    Outcome(groups, date, left_out)                one sample
    [Outcome | reason, ...], interval_ns           several
"""

import json
import math
import re
from datetime import datetime, timedelta, timezone
from functools import cache
from typing import Any, NamedTuple

GROUPS = {
    "orientation": "xyzw",
    "angular_velocity": "xyz",
    "linear_acceleration": "xyz",
    "magnetic_field": "xyz",
}
FACTORS = {
    "rad/s": 1.0,
    "mrad/s": 1e-3,
    "deg/s": math.pi / 180.0,
    "m/s^2": 1.0,
    "g": 9.80665,
    "mg": 9.80665 * 1e-3,
    "T": 1.0,
    "uT": 1e-6,
    "nT": 1e-9,
    "G": 1e-4,
    "mG": 1e-7,
}
SECONDS = {"s": 10**9, "ms": 10**6, "us": 10**3, "ns": 1}
NUMBER = re.compile(r"-?(0|[1-9][0-9]*)(\.[0-9]+)?([eE][-+]?[0-9]+)?")
# Of a step: a quoted key, another key, or brackets, in which there may be quotes and indices.
PIECES = re.compile(r""""(?:[^"\\]|\\.)*"|[^\["]+|\[(?:"(?:[^"\\]|\\.)*"|[^"\]\[]|\[[0-9]+\])*\]""")
NOTHING: Any = type("Nothing", (), {"__repr__": lambda self: "NOTHING"})()
SURPLUS: Any = type("Surplus", (), {"__repr__": lambda self: "SURPLUS"})()


class Outcome(NamedTuple):
    groups: dict[str, tuple[float, ...]]
    date_ns: int | None
    left_out: list[str]


class Fault(NamedTuple):
    reason: str


# The language: paths and conditions.


@cache
def split(text: str, sign: str) -> list[str]:
    """The parts of a text between signs that stand outside quotes and brackets."""
    parts, depth, quoted, escaped = [""], 0, False, False
    for letter in text:
        if quoted:
            quoted = letter != '"' or escaped
            escaped = letter == "\\" and not escaped
        elif letter == '"':
            quoted, escaped = True, False
        else:
            depth += (letter == "[") - (letter == "]")
        if letter == sign and not quoted and not depth:
            parts.append("")
        else:
            parts[-1] += letter
    return parts


@cache
def steps_of(text: str, texts_count: bool) -> list[Any]:
    """Keys as texts, indices as integers, conditions as lists of them, `[*]` as "*" in a tuple."""
    steps: list[Any] = []
    for part in split(text.strip(), "."):
        for piece in PIECES.findall(part):
            if piece == "[*]":
                steps.append(("*",))
            elif re.fullmatch(r"\[[0-9]+\]", piece):
                steps.append(int(piece[1:-1]))
            elif piece[0] == "[":
                if steps and isinstance(steps[-1], list):
                    steps[-1].append(condition_of(piece[1:-1], texts_count))
                else:
                    steps.append([condition_of(piece[1:-1], texts_count)])
            elif piece[0] == '"':
                steps.append(json.loads(piece))
            else:
                steps.append(int(piece) if re.fullmatch(r"0|[1-9][0-9]*", piece) else piece)
    return steps


@cache
def condition_of(text: str, texts_count: bool) -> Any:
    """Its paths, whether it is `=`, its value, and whether a text counts as a number."""
    left, *rest = split(text, "=")
    value: Any = "=".join(rest).strip()
    is_equal = not left.rstrip().endswith("!")
    paths = [steps_of(path, texts_count) for path in split(left.strip().removesuffix("!"), "|")]
    if NUMBER.fullmatch(value) or value in ("true", "false", "null") or value[0] == '"':
        value = json.loads(value)
    return paths, is_equal, value, texts_count


def way_of(text: str, mapping: dict[str, Any]) -> tuple[float, list[Any]]:
    text, texts_count = text.strip(), mapping.get("numeric_strings", False)
    sign = -1.0 if text[0] == "-" else 1.0
    return sign, steps_of(text.removeprefix("-"), texts_count)


def meets(value: Any, condition: Any) -> bool:
    if not isinstance(value, (dict, list)):
        return False
    paths, is_equal, wanted, texts_count = condition
    found = next((f for f in (find(value, path) for path in paths) if f is not NOTHING), NOTHING)
    is_number = isinstance(wanted, (int, float)) and not isinstance(wanted, bool)
    if texts_count and is_number and isinstance(found, str) and NUMBER.fullmatch(found.strip()):
        found = json.loads(found.strip())
    is_same = found is not NOTHING and found == wanted
    if isinstance(found, bool) != isinstance(wanted, bool):
        is_same = False
    return bool(is_same == is_equal)


def find(value: Any, steps: list[Any]) -> Any:
    """What is at a path without `[*]`; NOTHING or SURPLUS."""
    if not steps:
        return value
    step, rest = steps[0], steps[1:]
    if isinstance(step, list):
        if isinstance(value, list):
            found = [element for element in value if all(meets(element, c) for c in step)]
            if len(found) > 1:
                return SURPLUS
            return find(found[0], rest) if found else NOTHING
        return find(value, rest) if all(meets(value, c) for c in step) else NOTHING
    if isinstance(value, dict) and not isinstance(step, tuple) and str(step) in value:
        return find(value[str(step)], rest)
    if isinstance(value, list) and isinstance(step, int) and step < len(value):
        return find(value[step], rest)
    return NOTHING


def elements(value: Any, steps: list[Any]) -> Any:
    """The elements for the `[*]` behind these steps; SURPLUS if the list cannot be told."""
    if steps and isinstance(steps[-1], list):
        found = find(value, steps[:-1])
        if isinstance(found, list):
            return [e for e in found if all(meets(e, condition) for condition in steps[-1])]
    found = find(value, steps)
    return found if isinstance(found, list) or found is SURPLUS else []


def with_index(value: Any, steps: list[Any], k: int) -> Any:
    """What is at a path in sample `k`."""
    if ("*",) not in steps:
        return find(value, steps)
    at = steps.index(("*",))
    found = elements(value, steps[:at])
    return find(found[k], steps[at + 1 :]) if found is not SURPLUS and k < len(found) else NOTHING


# More than is read.


def unconditional(steps: list[Any]) -> list[Any]:
    return [step for step in steps if not isinstance(step, list)]


class Named(NamedTuple):
    """The paths of a mapping, without conditions."""

    quantities: list[list[Any]]
    times: list[list[Any]]
    conditions: list[list[Any]]
    """The paths in conditions, from the top of the payload."""


def paths_named(mapping: dict[str, Any]) -> Named:
    texts = [t for group in GROUPS for t in mapping.get(f"{group}_paths", ())]
    for group, axes in GROUPS.items():
        if len(mapping.get(f"{group}_paths", ())) == 1:
            (lone,) = mapping[f"{group}_paths"]
            texts += ["|".join(f"{way}[{n}]" for way in split(lone, "|")) for n in range(len(axes))]
    times = [*mapping.get("time_paths", ())]
    interval = mapping.get("time_interval", "").rpartition(" ")[0]
    if interval and not NUMBER.fullmatch(interval):
        times.append(interval)
    named = Named([], [], [])
    for found, into in ((texts, named.quantities), (times, named.times)):
        for way in (way for text in found for way in split(text, "|")):
            steps = way_of(way, mapping)[1]
            into.append(unconditional(steps))
            for at, step in enumerate(steps):
                if isinstance(step, list):
                    # Of a list, the elements meet them.
                    each = [("*",)] if steps[at + 1 : at + 2] == [("*",)] else []
                    place = unconditional(steps[:at]) + each
                    named.conditions.extend(place + path for ways, *_ in step for path in ways)
    for text in mapping.get("select", ()):
        named.conditions.extend(condition_of(text, False)[0])
    return named


def next_steps(paths: list[list[Any]], place: list[Any]) -> set[Any]:
    """The steps that these paths take from a place."""
    size = len(place)
    return {path[size] for path in paths if len(path) > size and path[:size] == place}


def is_surplus(mapping: dict[str, Any], value: Any, steps: list[Any], k: int, end: int) -> bool:
    """Whether an index among the first `end` steps leaves the same unread beside it."""
    if not any(isinstance(step, int) for step in steps[:end]):
        return False
    named = paths_named(mapping)
    for at, index in enumerate(steps[:end]):
        if not isinstance(index, int):
            continue
        before, rest = steps[:at], steps[at + 1 :]
        place = unconditional(before)
        paths = named.quantities + named.times + named.conditions
        known = {n for n in next_steps(paths, place) if isinstance(n, int)}
        found = with_index(value, before, k)
        if not isinstance(found, list):
            continue
        if not rest:
            first = min(n for n in next_steps(named.quantities, place) if isinstance(n, int))
            size = max(known) + 1
            wholes = [len(found) % size == 0, (len(found) - first) % (size - first) == 0]
            if len(found) > size and any(wholes):
                return True
        elif any(leads(e, rest) for n, e in enumerate(found) if n not in known):
            return True
    return False


def leads(value: Any, steps: list[Any]) -> bool:
    if ("*",) in steps:
        at = steps.index(("*",))
        found = elements(value, steps[:at])
        return found is SURPLUS or any(leads(element, steps[at + 1 :]) for element in found)
    return find(value, steps) not in (NOTHING, None)


# Zeros that are left out.


class Told(NamedTuple):
    """What an object without a key tells of a zero."""

    is_misspelt: bool
    """Whether it has the key in other letter case."""
    is_reading: bool
    """Whether it has a key that is read, or none but those in conditions."""


def told_by(mapping: dict[str, Any], found: dict[str, Any], place: list[Any], key: str) -> Told:
    named = paths_named(mapping)
    read = {str(s) for s in next_steps(named.quantities + named.times, place)}
    tested = {str(s) for s in next_steps(named.conditions, place)}
    others = [other for other in found if other not in read and other not in tested]
    is_misspelt = any(other.casefold() == key.casefold() for other in others)
    return Told(is_misspelt, is_reading=not others or any(other in read for other in found))


def is_left_out(mapping: dict[str, Any], payload: Any, steps: list[Any], k: int) -> bool:
    """Whether a path that leads to nothing ends at an object, as when a zero is left out."""
    if not isinstance(steps[-1], str):
        return False
    start = steps.index(("*",)) + 1 if ("*",) in steps else 0
    for at in range(start, len(steps)):
        if with_index(payload, steps[: at + 1], k) is NOTHING:
            found = with_index(payload, steps[:at], k)
            if not isinstance(found, dict) or not isinstance(steps[at], str):
                return False
            told = told_by(mapping, found, unconditional(steps[:at]), steps[at])
            return told.is_reading and not told.is_misspelt
    return False


# Numbers and quantities.


def number_of(value: Any, factor: float, limit: float, mapping: dict[str, Any]) -> float | Fault:
    if (
        isinstance(value, str)
        and mapping.get("numeric_strings")
        and NUMBER.fullmatch(value.strip())
    ):
        value = float(value)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return Fault("wrong_type")
    try:
        number = float(value)
    except OverflowError:
        return Fault("out_of_range")
    if not math.isfinite(number) or not math.isfinite(number * factor):
        return Fault("non_finite")
    return Fault("out_of_range") if abs(number * factor) > limit else number * factor


class Quantity:
    """A quantity of a mapping: its ways for each alternative, components in their order."""

    def __init__(self, mapping: dict[str, Any], group: str) -> None:
        self.mapping, self.group = mapping, group
        axes = GROUPS[group]
        texts = mapping[f"{group}_paths"]
        self.is_whole = len(texts) == 1
        alternatives = [[way_of(way, mapping) for way in split(text, "|")] for text in texts]
        if self.is_whole:
            alternatives = [[(s, [*w, n]) for s, w in alternatives[0]] for n in range(len(axes))]
        written = (mapping.get("orientation_order") or axes) if group == "orientation" else axes
        in_order = [alternatives[written.index(axis)] for axis in axes]
        self.alternatives = [list(ways) for ways in zip(*in_order, strict=True)]
        self.factor = FACTORS[mapping[f"{group}_unit"]] if group != "orientation" else 1.0
        scales = {"angular_velocity": 69.8132, "linear_acceleration": 313.8128}
        scales |= {"magnetic_field": 0.01, "orientation": 1e9}
        self.limit = mapping.get(f"{group}_full_scale", scales[group])

    def single(self, payload: Any) -> Any:
        """Numbers, a Fault, or None."""
        return self.first_of(lambda ways, zeros: self.sample(payload, ways, 0, zeros=zeros))

    def several(self, payload: Any) -> Any:
        """A list of them, one Fault for all, or None."""
        return self.first_of(lambda ways, zeros: self.rows(payload, ways, zeros=zeros))

    def first_of(self, look: Any) -> Any:
        """The first alternative with a value; else the first."""
        for zeros in (False, True) if self.mapping.get("absent") == "zero" else (True,):
            for ways in self.alternatives:
                found = look(ways, zeros)
                is_nothing = found is None or (
                    not zeros and isinstance(found, list) and all(one is None for one in found)
                )
                if not is_nothing:
                    return look(ways, True)
        return None

    def rows(self, payload: Any, ways: list[Any], *, zeros: bool) -> Any:
        cuts = [steps.index(("*",)) for _, steps in ways]
        lists = [elements(payload, s[:at]) for (_, s), at in zip(ways, cuts, strict=True)]
        if all(found == [] for found in lists):
            return None
        if SURPLUS in lists or any(self.is_surplus_before(payload, s) for _, s in ways):
            return Fault("surplus")
        counts = {len(found) for found in lists if found}
        if len(counts) > 1:
            return Fault("uneven")
        return [self.sample(payload, ways, k, zeros=zeros) for k in range(max(counts))]

    def is_surplus_before(self, payload: Any, steps: list[Any]) -> bool:
        """Whether an index before the `[*]` leaves the same unread, in any element."""
        return is_surplus(self.mapping, payload, steps, 0, end=steps.index(("*",)))

    def sample(self, payload: Any, ways: list[Any], k: int, *, zeros: bool) -> Any:
        found = [with_index(payload, steps, k) for _, steps in ways]
        if all(value in (NOTHING, None) for value in found):
            return self.zeros(payload, ways, k) if zeros else None
        for value, (_, steps) in zip(found, ways, strict=True):
            # The length of a list of all components is another matter.
            end = len(steps) - self.is_whole
            if value is SURPLUS or is_surplus(self.mapping, payload, steps, k, end=end):
                return Fault("surplus")
        zero = self.mapping.get("absent") == "zero"
        for value, (_, steps) in zip(found, ways, strict=True):
            if value is NOTHING and not (zero and is_left_out(self.mapping, payload, steps, k)):
                return Fault("incomplete")
        if self.is_whole:
            parent = with_index(payload, ways[0][1][:-1], k)
            if isinstance(parent, list) and len(parent) != len(ways):
                return Fault("wrong_type")
        return self.convert([0 if value is NOTHING else value for value in found], ways)

    def zeros(self, payload: Any, ways: list[Any], k: int) -> Any:
        parents = [steps[:-1] for _, steps in ways]
        keys = [steps[-1] for _, steps in ways]
        if self.mapping.get("absent") != "zero" or not all(isinstance(key, str) for key in keys):
            return None
        if any(parent != parents[0] for parent in parents) or not parents[0]:
            return None
        parent = with_index(payload, parents[0], k)
        if not isinstance(parent, dict) or any(key in parent for key in keys):
            return None
        place = unconditional(parents[0])
        told = [told_by(self.mapping, parent, place, key) for key in keys]
        if any(one.is_misspelt for one in told):
            return Fault("incomplete")
        return self.convert([0] * len(ways), ways) if told[0].is_reading else None

    def convert(self, values: list[Any], ways: list[Any]) -> Any:
        if any(self.is_sentinel(value) for value in values):
            return None
        numbers = []
        for value, (sign, _) in zip(values, ways, strict=True):
            number = number_of(value, self.factor * sign, self.limit, self.mapping)
            if isinstance(number, Fault):
                return number
            numbers.append(number)
        return self.rotation(numbers) if self.group == "orientation" else tuple(numbers)

    def is_sentinel(self, value: Any) -> bool:
        number = number_of(value, 1.0, math.inf, self.mapping)
        return not isinstance(number, Fault) and number in self.mapping.get("sentinels", ())

    def rotation(self, numbers: list[float]) -> Any:
        norm = math.hypot(*numbers)
        if abs(norm - 1.0) > max(1e-6, self.mapping.get("quaternion_tolerance", 0.05)):
            return Fault("bad_quaternion")
        if abs(norm - 1.0) <= 1e-6:
            return tuple(numbers)
        return tuple(number / norm for number in numbers)


# Time.


def nanoseconds(value: Any, unit: int, mapping: dict[str, Any]) -> int | None:
    if isinstance(value, str) and NUMBER.fullmatch(value.strip()):
        if not mapping.get("numeric_strings"):
            return None
        try:
            value = json.loads(value.strip())
        except ValueError:
            return None
    elif isinstance(value, str):
        return from_iso(value.strip().upper())
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    if isinstance(value, float) and not abs(value) < 1e18:
        return None
    return int(value) * unit if value == int(value) else int(value * unit)


ISO = re.compile(
    r"([0-9]{4})-([0-9]{2})-([0-9]{2})[T ]([0-9]{2}):([0-9]{2}):([0-9]{2})"
    r"(?:[.,]([0-9]+))?(Z|[-+][0-9]{2}:[0-9]{2})?"
)


def from_iso(text: str) -> int | None:
    """The date of a text in upper case that is written as usual; no case has another."""
    found = ISO.fullmatch(text)
    if found is None:
        return None
    year, month, day, hour, minute, second = map(int, found.groups()[:6])
    micros = int(((found[7] or "") + "000000")[:6])
    if hour > 24 or minute > 59 or second > 60 or found[8] is None:
        return None
    if hour == 24 and (minute or second or micros):
        return None
    zone = "+00:00" if found[8] == "Z" else found[8]
    offset = timedelta(hours=int(zone[1:3]), minutes=int(zone[4:]))
    try:
        date = datetime(year, month, day, tzinfo=timezone.utc)
        date += timedelta(hours=hour, minutes=minute, seconds=second, microseconds=micros)
        date -= -offset if zone[0] == "-" else offset
    except (ValueError, OverflowError):
        return None
    if second == 60 and (date.day, date.hour, date.minute, date.second) != (1, 0, 0, 0):
        return None
    return (date - datetime(1970, 1, 1, tzinfo=timezone.utc)) // timedelta(microseconds=1) * 1000


def date_of(values: list[Any], units: list[int], mapping: dict[str, Any]) -> int | None:
    parts = [nanoseconds(v, unit, mapping) for v, unit in zip(values, units, strict=True)]
    known = [part for part in parts if part is not None]
    if len(known) < len(parts):
        return None
    if len(parts) == 2:
        is_text = isinstance(values[1], str) and not NUMBER.fullmatch(values[1].strip())
        if known[0] % 10**9 or not 0 <= known[1] < 10**9 or is_text:
            return None
    return is_possible(sum(known))


def is_possible(date_ns: int) -> int | None:
    first = int(datetime(1980, 1, 1, tzinfo=timezone.utc).timestamp()) * 10**9
    last = int(datetime(9999, 12, 31, tzinfo=timezone.utc).timestamp()) * 10**9
    return date_ns if first <= date_ns < last + 86_400 * 10**9 else None


class Dates:
    def __init__(self, mapping: dict[str, Any]) -> None:
        self.mapping = mapping
        texts = mapping["time_paths"]
        ways = [[way_of(way, mapping)[1] for way in split(text, "|")] for text in texts]
        self.alternatives = [list(steps) for steps in zip(*ways, strict=True)]
        self.units = [SECONDS[mapping["time_unit"]]] if len(texts) == 1 else [10**9, 1]

    def at(self, payload: Any, ways: list[Any], k: int) -> Any:
        """The date of a sample, None if it is no date, NOTHING if there is none."""
        found = [with_index(payload, steps, k) for steps in ways]
        if all(value in (NOTHING, None) for value in found):
            return NOTHING
        zero = self.mapping.get("absent") == "zero"
        values = [
            0
            if value is NOTHING and zero and is_left_out(self.mapping, payload, steps, k)
            else value
            for value, steps in zip(found, ways, strict=True)
        ]
        return date_of(values, self.units, self.mapping)

    def single(self, payload: Any) -> int | None:
        for ways in self.alternatives:
            date = self.at(payload, ways, 0)
            if date is not NOTHING:
                return date  # type: ignore[no-any-return]  # not NOTHING, so a date
        return None

    def several(self, payload: Any, count: int, interval: int | None) -> list[int | None]:
        if ("*",) not in self.alternatives[0][0]:
            start = self.single(payload)
            if start is None or interval is None:
                return [None] * count
            return [is_possible(start + k * interval) for k in range(count)]
        for ways in self.alternatives:
            lists = [elements(payload, steps[: steps.index(("*",))]) for steps in ways]
            lists = [[] if found is SURPLUS else found for found in lists]
            counts = {len(found) for found in lists if found}
            if not counts:
                continue
            if counts != {count}:
                return [None] * count
            dates = [self.at(payload, ways, k) for k in range(count)]
            return [None if date is NOTHING else date for date in dates]
        return [None] * count


def interval_of(payload: Any, mapping: dict[str, Any]) -> int | None:
    text = mapping.get("time_interval", "")
    if not text:
        return None
    what, unit = text.rsplit(" ", 1)
    value: Any = json.loads(what) if NUMBER.fullmatch(what) else NOTHING
    if value is NOTHING:
        for way in split(what, "|"):
            value = find(payload, way_of(way, mapping)[1])
            if value not in (NOTHING, None):
                break
    number = number_of(value, 1.0, math.inf, mapping)
    if isinstance(number, Fault) or number <= 0.0:
        return None
    interval = 1e9 / number if unit == "Hz" else number * SECONDS[unit]
    return round(interval) if 1 <= interval <= 60e9 else None


# A whole payload.


def together(mapping: dict[str, Any], results: dict[str, Any], date: Any) -> Outcome | str:
    """One sample, of what has been read of each quantity."""
    required = mapping.get("required", ())
    for group in GROUPS:
        if group in required and isinstance(results.get(group), Fault):
            return str(results[group].reason)
    faults = [r.reason for r in results.values() if isinstance(r, Fault)]
    good = {g: r for g, r in results.items() if isinstance(r, tuple) and not isinstance(r, Fault)}
    if not good and not faults:
        return "no_imu_data"
    if any(results.get(group) is None for group in required):
        return "missing_group"
    if not good:
        return faults[0]
    is_wanted = date is not NOTHING
    undated = ["time_unusable"] if is_wanted and date is None else []
    return Outcome(good, date if is_wanted else None, faults + undated)


def read(mapping: dict[str, Any], payload: Any, *, device_time: bool) -> Any:
    """What the mapping makes of the payload."""
    for text in mapping.get("select", ()):
        if not meets(payload, condition_of(text, mapping.get("numeric_strings", False))):
            return "not_selected"
    quantities = {g: Quantity(mapping, g) for g in GROUPS if mapping.get(f"{g}_paths")}
    dates = Dates(mapping) if device_time else None
    if not any("[*]" in text for g in quantities for text in mapping[f"{g}_paths"]):
        results = {group: quantity.single(payload) for group, quantity in quantities.items()}
        return together(mapping, results, dates.single(payload) if dates else NOTHING)
    several = {group: quantity.several(payload) for group, quantity in quantities.items()}
    lists = {group: found for group, found in several.items() if isinstance(found, list)}
    required = [group for group in lists if group in mapping.get("required", ())]
    counts = {len(lists[group]) for group in required or lists}
    if len(counts) > 1:
        return "uneven"
    if not counts:
        return together(mapping, several, NOTHING)
    (count,) = counts
    interval = interval_of(payload, mapping)
    when = dates.several(payload, count, interval) if dates else [NOTHING] * count
    samples = []
    for k in range(count):
        results = {
            group: found
            if not isinstance(found, list)
            else (found[k] if len(found) == count else Fault("uneven"))
            for group, found in several.items()
        }
        samples.append(together(mapping, results, when[k]))
    return samples, interval
