"""Every example of the page of checks: its frames are sent to a reader, which must say the rest."""

import json
import re
from collections.abc import Callable
from typing import Any

import pytest

from rosbase.imu.checks.suite import CheckSettings
from rosbase.imu.diagnosis.explanations import Explanations
from rosbase.imu.diagnosis.payload import mapped_by
from rosbase.imu.health import HealthLevel
from rosbase.imu.settings import READER_PARAMETERS, read_settings, reader_parameters
from rosbase.mapping.rejects import Reject
from rosbase.plugins import installed_plugins
from support.code_blocks import ROOT, blocks_of
from support.reader_rig import Rig

PAGE = "docs/checks.md"
TEXT = (ROOT / PAGE).read_text()
EXAMPLES = [block.text for block in blocks_of(PAGE, "text")]
DEVICE: dict[str, Any] = {
    "preset": "custom",
    "mapping.linear_acceleration.paths": ["acc"],
    "mapping.linear_acceleration.unit": "m/s^2",
    "mapping.angular_velocity.paths": ["gyr"],
    "mapping.angular_velocity.unit": "rad/s",
    "mapping.orientation.paths": ["q"],
    "mapping.time.paths": ["at"],
    "mapping.time.unit": "s",
}
S = 1_000_000_000
PERIOD_NS = S // 20


class Player:
    """Plays an example, line by line."""

    def __init__(self, example: str) -> None:
        self.lines = example.splitlines()
        given = [line[3:].split(":=") for line in self.lines if line.startswith("-p")]
        values = {name: json.loads(v) if v.startswith("[") else v for name, v in given}
        self.rig = Rig(**{**DEVICE, **values}).activate()
        self.now_ns = 1_780_000_000 * S
        self.sent = 0

    def play(self) -> None:
        steps: dict[str, Callable[[re.Match[str]], None]] = {
            r"-p .+": lambda found: None,
            r"([\d.]+) s of (.+)": self.send,
            r"WARN (.+)": self.warns,
            r"OK": self.is_well,
            r"published (\d+)": self.published,
            r"(\w+) (\d+)": self.counted,
        }
        for line in self.lines:
            pattern = next(pattern for pattern in steps if re.fullmatch(pattern, line))
            found = re.fullmatch(pattern, line)
            assert found
            steps[pattern](found)

    def send(self, found: re.Match[str]) -> None:
        for _ in range(round(float(found[1]) * S / PERIOD_NS)):
            frame = re.sub(r"NOW( [+-] \d+)?", self.date, found[2])
            self.rig.send(frame.encode(), self.now_ns)
            self.now_ns += PERIOD_NS
            self.rig.pass_time(PERIOD_NS / S)
        # The health is judged now and then.
        self.rig.pass_time(0.5)

    def date(self, found: re.Match[str]) -> str:
        return repr(self.now_ns / S + int((found[1] or "0").replace(" ", "")))

    def warns(self, found: re.Match[str]) -> None:
        assert self.rig.reader.health.level is HealthLevel.WARN
        assert found[1] in self.rig.reader.health.message

    def is_well(self, found: re.Match[str]) -> None:
        assert self.rig.reader.health.level is HealthLevel.OK, self.rig.reader.health

    def published(self, found: re.Match[str]) -> None:
        assert self.rig.reader.counts.published == int(found[1])

    def counted(self, found: re.Match[str]) -> None:
        assert self.rig.reader.counts.by_reason[found[1]] == int(found[2])


def test_every_section_of_a_check_has_an_example() -> None:
    sections = re.split(r"^## ", TEXT, flags=re.M)[1:7]
    assert all("```text" in section for section in sections)
    assert len(EXAMPLES) == 9


@pytest.mark.parametrize("example", EXAMPLES)
def test_an_example_happens_as_it_is_shown(example: str) -> None:
    player = Player(example)
    try:
        player.play()
    finally:
        player.rig.backend.close()


CAUSES = re.findall(r"^\| `(\S.+?)` \| (.+) \|$", TEXT.split("## Refused frames")[1], re.M)


def test_there_are_examples_of_causes() -> None:
    assert len(CAUSES) >= 12


@pytest.mark.parametrize(("frame", "said"), CAUSES)
def test_a_cause_is_said_as_it_is_shown(frame: str, said: str) -> None:
    specs = reader_parameters(installed_plugins())
    values = {spec.name: spec.default for spec in specs} | DEVICE
    mapping = read_settings(installed_plugins(), values.__getitem__).mapping
    reject = mapping.compile()(frame.encode())
    assert isinstance(reject, Reject)
    cause = Explanations({}, mapped_by(mapping)).explain(reject, frame.encode())
    assert cause.text == said


def test_the_table_names_every_parameter_of_the_checks_with_its_default_and_values() -> None:
    specs = {spec.name: spec for spec in READER_PARAMETERS}
    rows = re.findall(r"^\| `(\w+)` \| `?([^|`]+)`? \| ([^|]+) \| [^|]+ \|$", TEXT, re.M)
    first, last = list(specs).index("plausibility"), list(specs).index("checksum_separator")
    assert [name for name, _, _ in rows] == list(specs)[first : last + 1]
    for name, default, values in rows:
        assert str(specs[name].default) == default.strip()
        if specs[name].choices:
            assert re.findall(r"`(\w+)`", values) == list(specs[name].choices)
    assert len(rows) == len(CheckSettings.__attrs_attrs__)


def test_a_frame_of_the_page_is_json_where_it_should_be() -> None:
    for example in EXAMPLES:
        for line in re.findall(r" s of (\{.+\})", example):
            json.loads(re.sub(r"NOW( [+-] \d+)?", "0", line))
