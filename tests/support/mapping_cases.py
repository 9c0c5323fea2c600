"""Mappings and payloads for them, good and hostile, made by a random number generator.

Made by a generator and not as strategies, so that a million of them take minutes; hypothesis,
which shrinks, brings a generator of its own (`st.randoms`).
"""

import json
from copy import deepcopy
from random import Random
from typing import Any, NamedTuple

from support.mapping_oracle import GROUPS

Token = Any
"""A key (text), an index (integer), conditions (a list), or `[*]` (a tuple)."""

EACH = ("*",)
UNITS = {
    "angular_velocity": ["rad/s", "deg/s", "mrad/s"],
    "linear_acceleration": ["m/s^2", "g", "mg"],
    "magnetic_field": ["T", "uT", "G"],
}
KEYS = ["a", "b", "v", "x", "007", "k.d", "0", "to do", 'say "x"', "Ärm"]
TAGS = ["acc", "gyr", 'a]"b', 7, 7.5, 1, 0, True, False, None, -1]


class Case(NamedTuple):
    fields: dict[str, Any]
    """Of an `ImuMapping`."""
    payload: Any
    device_time: bool


def make_cases(rng: Random, payloads: int) -> list[Case]:
    """One mapping, and payloads for it."""
    maker = _Maker(rng)
    fields = maker.fields()
    device_time = bool(fields["time_paths"]) and rng.random() < 0.7
    if not device_time and rng.random() < 0.5:
        fields["time_paths"], fields["time_unit"] = (), ""
    return [Case(fields, maker.payload(), device_time) for _ in range(payloads)]


def anything(rng: Random, depth: int = 2) -> Any:
    """Any value of JSON, such as a device would never send."""
    kinds = 12 if depth else 10
    match rng.randrange(kinds):
        case 0:
            return None
        case 1:
            return rng.random() < 0.5
        case 2:
            return rng.choice([10**400, -(10**400), 2**53 + 1, 10**17, 10**18])
        case 3:
            return rng.choice([float("nan"), float("inf"), -float("inf"), 1e300, -0.0, 5e-324])
        case 4:
            return rng.choice(["1.5", "-0", "1e999", "nan", "1_0", " 2 ", "x", "", "acc"])
        case 5:
            return rng.choice([69.8131, 69.8133, -313.8127, 313.8129, 0.0099, 0.0101, 4001.0])
        case 6 | 7:
            return rng.randrange(-3, 12)
        case 8 | 9:
            return round(rng.uniform(-12.0, 12.0), 3)
        case 10:
            return [anything(rng, depth - 1) for _ in range(rng.randrange(5))]
    return {rng.choice(KEYS): anything(rng, depth - 1) for _ in range(rng.randrange(4))}


def _text(tokens: list[Token]) -> str:
    text = ""
    for token in tokens:
        if isinstance(token, list):
            text += "".join(f"[{condition}]" for _, _, condition in token)
        elif isinstance(token, (int, tuple)):
            text += f"[{token}]" if isinstance(token, int) else "[*]"
        else:
            plain = token.replace("_", "").isalnum() and token != "0"
            text += ("." if text else "") + (token if plain else json.dumps(token))
    return text


class _Maker:
    """Makes a mapping; then payloads that fit, more or less."""

    def __init__(self, rng: Random) -> None:
        self.rng = rng
        self.is_batch = rng.random() < 0.4
        self.quantities: dict[str, list[list[list[Token]]]] = {}
        """By group: for each alternative the tokens to each component, or to the whole."""
        self.times: list[list[list[Token]]] = []
        self.interval: list[Token] = []
        self.selected: list[Token] = []
        self.sentinels: tuple[float, ...] = ()

    # The mapping.

    def fields(self) -> dict[str, Any]:
        rng = self.rng
        groups = rng.sample(list(GROUPS), rng.randrange(1, 5))
        shared = self.prefix() if rng.random() < 0.5 else None
        fields: dict[str, Any] = {"orientation_order": ""}
        for group in groups:
            alternatives = [
                self.alternative(group, shared, n) for n in range(rng.choice([1, 1, 2]))
            ]
            self.quantities[group] = self.alike(alternatives)
            fields[f"{group}_paths"] = self.texts(self.quantities[group])
            if group in UNITS:
                fields[f"{group}_unit"] = rng.choice(UNITS[group])
            elif rng.random() < 0.4:
                fields["orientation_order"] = rng.choice(["wxyz", "xyzw"])
        fields["required"] = tuple(group for group in groups if rng.random() < 0.4)
        fields["absent"] = rng.choice(["missing", "missing", "zero"])
        fields["numeric_strings"] = rng.random() < 0.3
        fields["sentinels"] = self.sentinels = rng.choice([(), (), (-999.0,), (65535.0, 0.5)])
        fields["select"] = self.select()
        fields["time_interval"] = ""
        fields["time_paths"], fields["time_unit"] = (), ""
        if rng.random() < 0.6:
            self.time(fields)
        if self.is_batch and (self.times_need_interval() or rng.random() < 0.2):
            self.interval = [rng.choice(["rate", "dt"])]
            what = rng.choice(["5 ms", "200 Hz", f"{self.interval[0]} {rng.choice(['Hz', 'ms'])}"])
            fields["time_interval"] = what
        return fields

    def prefix(self) -> list[Token]:
        """The way to a quantity."""
        rng = self.rng
        tokens: list[Token] = []
        for _ in range(rng.choice([0, 1, 1, 1, 2, 2, 3])):
            kind = rng.random()
            if kind < 0.55 or (tokens and isinstance(tokens[-1], list)):
                tokens.append(rng.choice(KEYS))
            elif kind < 0.75:
                tokens.append(rng.randrange(3))
            else:
                tokens.append([self.condition() for _ in range(rng.choice([1, 1, 2]))])
        return tokens

    def condition(self, path: str = "", value: Any = EACH) -> Any:
        """The tokens to a value, what it is to be (or not), and the text."""
        rng = self.rng
        tokens: list[Token] = [path or rng.choice(["name", "type", "k.d", "id"])]
        if not path and rng.random() < 0.4:
            tokens.append(rng.choice([0, 1, "sub"]))
        value = rng.choice(TAGS) if value is EACH else value
        is_equal = rng.random() < 0.75
        shown = value if isinstance(value, str) and value.isalnum() else json.dumps(value)
        text = f"{_text(tokens)}{'=' if is_equal else '!='}{shown}"
        return tokens, (value if is_equal else EACH), text

    def alternative(self, group: str, shared: list[Token] | None, number: int) -> list[list[Token]]:
        """The tokens to each component, or one to the whole."""
        rng = self.rng
        before = list(shared if shared is not None else self.prefix())
        own = f"{group[:3]}{number or ''}"
        if rng.random() < 0.3 and not (before and isinstance(before[-1], list)):
            where = [self.condition("name", own)]
            before.append([(tokens, own, f"name={own}") for tokens, _, _ in where])
        else:
            before.append(own)
        axes = GROUPS[group]
        style = rng.choice(["keys", "keys", "whole", "indices", "apart", "flat"])
        ends: list[list[Token]] = [[]]
        if style == "flat":
            before = before[: rng.randrange(2)] if rng.random() < 0.5 else []
            ends = [[f"{own}{axis}"] for axis in axes]
        elif style == "keys":
            ends = [[axis] for axis in axes]
        elif style == "indices":
            first = rng.choice([0, 0, 1])
            ends = [[first + n] for n in range(len(axes))]
        elif style == "apart":
            ends = [[axis, rng.choice(["v", "k.d", 0])] for axis in axes]
        if not self.is_batch:
            return [before + end for end in ends]
        if rng.random() < 0.3:
            return [before + end + [EACH] for end in ends]
        at = rng.randrange(len(before) + 1)
        while at and at < len(before) and isinstance(before[at], list) and rng.random() < 0.5:
            at -= 1
        return [[*before[:at], EACH, *before[at:], *end] for end in ends]

    def alike(self, alternatives: list[list[list[Token]]]) -> list[list[list[Token]]]:
        """Those of the same number of paths as the first, since they belong together."""
        return [paths for paths in alternatives if len(paths) == len(alternatives[0])]

    def texts(self, alternatives: list[list[list[Token]]]) -> tuple[str, ...]:
        signs = [["-" if self.rng.random() < 0.1 else "" for _ in a] for a in alternatives]
        return tuple(
            "|".join(
                sign + _text(tokens) for sign, tokens in zip(column_signs, column, strict=True)
            )
            for column_signs, column in zip(
                zip(*signs, strict=True), zip(*alternatives, strict=True), strict=True
            )
        )

    def select(self) -> tuple[str, ...]:
        if self.rng.random() < 0.7:
            return ()
        condition = self.condition("T", self.rng.choice([1002, "imu"]))
        self.selected = [condition]
        return (condition[2],)

    def time(self, fields: dict[str, Any]) -> None:
        rng = self.rng
        before: list[Token] = [rng.choice(["t", "header"])]
        if self.is_batch and rng.random() < 0.6:
            before.insert(rng.randrange(2), EACH)
        if rng.random() < 0.5:
            self.times = [[before], [["stamp", *before]]][: rng.choice([1, 2])]
            fields["time_unit"] = rng.choice(["s", "ms", "us", "ns"])
        else:
            self.times = [[[*before, "sec"], [*before, "nsec"]]]
        fields["time_paths"] = tuple(
            "|".join(_text(tokens) for tokens in column) for column in zip(*self.times, strict=True)
        )
        self.unit = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}.get(fields["time_unit"], 0)

    def times_need_interval(self) -> bool:
        return bool(self.times) and EACH not in self.times[0][0]

    # Payloads.

    def payload(self) -> Any:
        rng = self.rng
        if rng.random() < 0.05:
            return rng.choice([[anything(rng, 3)], [], {}, {"a": anything(rng, 3)}])
        count = rng.choice([1, 2, 3, 4])
        payload: Any = None
        for group, alternatives in self.quantities.items():
            if rng.random() < 0.9:
                own = count if rng.random() < 0.95 else rng.randrange(4)
                rows = [self.numbers(group) for _ in range(own if self.is_batch else 1)]
                payload = self.put_quantity(payload, rng.choice(alternatives), rows)
        if self.times and rng.random() < 0.9:
            dates = [self.date() for _ in range(count if self.is_batch else 1)]
            ways = rng.choice(self.times)
            for part, way in enumerate(ways):
                payload = self.put(payload, way, [date[part] for date in dates])
        if self.interval and rng.random() < 0.9:
            payload = self.put(payload, self.interval, [rng.choice([5, 200, 100.0, "50", 0, -1])])
        for tokens, value, _ in self.selected:
            if rng.random() < 0.9:
                payload = self.put(payload, tokens, [value if value is not EACH else 5])
        for _ in range(rng.choice([0, 0, 0, 1, 1, 2, 4])):
            payload = self.damaged(payload)
        return payload if isinstance(payload, (dict, list)) else [payload]

    def numbers(self, group: str) -> list[Any]:
        numbers = self.readings(group)
        if self.sentinels and self.rng.random() < 0.2:
            lost = self.rng.choice([*self.sentinels, int(self.sentinels[0]), "-999"])
            numbers[self.rng.randrange(len(numbers))] = lost
        return numbers

    def readings(self, group: str) -> list[Any]:
        rng = self.rng
        if group == "orientation":
            units: list[list[Any]] = [
                [0, 0, 0, 1],
                [0.6, 0.0, 0.0, 0.8],
                [1.0, 0.0, 0.0, 0.0],
                [0.71, 0, 0, 0.71],
            ]
            others: list[list[Any]] = [[0.5, 0.5, 0.5, 0.5], [0, 0, 0, 0], [3, 2, 1, 0]]
            numbers: list[Any] = rng.choice(units + others)
            return [*numbers]
        scale = 1e-5 if group == "magnetic_field" else 5.0
        if rng.random() < 0.6:
            return [rng.uniform(-scale, scale) for _ in "xyz"]
        return [rng.choice([0, 1, rng.uniform(-scale, scale)]) for _ in "xyz"]

    def date(self) -> list[Any]:
        rng = self.rng
        seconds = rng.choice([1_700_000_000, 1_812_345_678, 12, 2**31])
        if not self.unit:
            whole = rng.choice([seconds, seconds, float(seconds), seconds + 0.25, str(seconds)])
            first = self.iso() if rng.random() < 0.1 else whole
            return [first, rng.choice([0, 5, 5.0, "7", 10**9, -1, self.iso()])]
        lone = seconds * self.unit
        return [rng.choice([lone, lone, lone + 0.5, str(lone), f"{lone}.25", self.iso()])]

    def iso(self) -> str:
        rng = self.rng
        zone = rng.choice(["Z", "Z", "z", "+02:00", "-05:30", ""])
        day = rng.choice(["2025-10-01", "2025-12-31", "2016-12-31", "2025-02-30"])
        clock = rng.choice(["12:00:00", "12:00:00.25", "24:00:00", "23:59:60", "18:29:60.5"])
        blank = rng.choice(["", "", " ", "\n"])
        return f"{blank}{day}{rng.choice('Tt ')}{clock}{zone}{blank}"

    def put_quantity(self, payload: Any, ways: list[list[Token]], rows: list[list[Any]]) -> Any:
        if len(ways) == 1:
            return self.put(payload, ways[0], rows)
        for at, tokens in enumerate(ways):
            payload = self.put(payload, tokens, [row[at] for row in rows])
        return payload

    def put(self, node: Any, tokens: list[Token], values: list[Any]) -> Any:
        """The node with the values where the tokens lead; as it is where that does not fit."""
        if not tokens:
            return values[0] if values else None
        token, rest = tokens[0], tokens[1:]
        if isinstance(token, tuple):
            return self.put_each(node, rest, values)
        if isinstance(token, list):
            return self.put_where(node, token, rest, values)
        if isinstance(token, int) and (isinstance(node, list) or node is None):
            node = [] if node is None else node
            while len(node) <= token:
                node.append(None)
            node[token] = self.put(node[token], rest, values)
        elif isinstance(node, dict) or node is None:
            node = {} if node is None else node
            node[str(token)] = self.put(node.get(str(token)), rest, values)
        return node

    def put_each(self, node: Any, rest: list[Token], values: list[Any]) -> Any:
        if node is None:
            node = []
        if isinstance(node, list):
            for at, value in enumerate(values):
                if at == len(node):
                    node.append(None)
                node[at] = self.put(node[at], rest, [value])
        return node

    def put_where(self, node: Any, where: list[Any], rest: list[Token], values: list[Any]) -> Any:
        rng = self.rng
        if isinstance(node, dict) or (node is None and rng.random() < 0.4):
            return self.put(self.meeting(node, where), rest, values)
        node = [] if node is None else node
        if isinstance(node, list):
            if rest and isinstance(rest[0], tuple):
                for value in values:
                    node.append(self.put(self.meeting(None, where), rest[1:], [value]))
            else:
                at = rng.randrange(len(node) + 1)
                node.insert(at, self.put(self.meeting(None, where), rest, values))
            if rng.random() < 0.3:
                node.append(rng.choice([anything(rng), self.decoy(node[-1] if node else None)]))
        return node

    def decoy(self, element: Any) -> dict[str, Any]:
        """An element like another, but for one value."""
        if not isinstance(element, dict) or not element:
            return {}
        return {**element, self.rng.choice(list(element)): self.rng.choice([*TAGS, None])}

    def meeting(self, node: Any, where: list[Any]) -> Any:
        for tokens, value, _ in where:
            if value is not EACH:
                is_text = isinstance(value, int) and self.rng.random() < 0.1
                node = self.put(node, tokens, [json.dumps(value) if is_text else value])
        return {} if node is None else node

    def damaged(self, payload: Any) -> Any:
        """The payload with something else, or nothing, in one place."""
        rng = self.rng
        payload = deepcopy(payload)
        places = list(_places(payload))
        if not places:
            return anything(rng)
        container, key = rng.choice(places)
        match rng.randrange(12):
            case 0 | 1:
                container[key] = anything(rng)
            case 2:
                del container[key]
            case 3 if isinstance(container, list):
                container.append(deepcopy(rng.choice(container)))
            case 4 if isinstance(container, list):
                container.reverse()
            case 5 if isinstance(container[key], (int, float)):
                container[key] = str(container[key])
            case 6 if isinstance(container[key], dict):
                container[key] = [container[key]]
            case 7 | 8 if isinstance(container, dict):
                container[key.swapcase()] = container.pop(key)
            case 9 if isinstance(container[key], (dict, list)):
                container[key] = rng.choice([{}, {}, {"error": "i2c timeout"}])
            case 9 if isinstance(container, dict):
                container["seq"] = 5
            case 10 | 11 if isinstance(container[key], list):
                tail = container[key][rng.randrange(2) :]
                container[key] += deepcopy(tail) * rng.randrange(1, 3)
            case 10 | 11:
                del container[key]
            case _:
                container[key] = None
        return payload


def _places(value: Any) -> Any:
    keys = (
        value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    )
    for key in list(keys):
        yield value, key
        yield from _places(value[key])
