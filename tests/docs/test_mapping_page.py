"""The examples of docs/mapping.md give what the page says, and its lists are whole."""

from datetime import datetime, timezone
from pathlib import Path
from typing import NamedTuple

import pytest

from rosbase import Batch, Reject
from rosbase.cli.arguments import check_given, read_given
from rosbase.imu.mapping import GROUPS, Sample
from rosbase.imu.settings import read_settings, reader_parameters
from rosbase.mapping.rejects import PAYLOAD_REASONS
from rosbase.plugins import installed_plugins
from rosbase.text.toml import parse_toml
from support.code_blocks import BLOCKS, ROOT

PAGE = ROOT / "docs/mapping.md"
KINDS = ("Flat", "Nested", "Tagged stream", "Batch", "Columns", "Protobuf JSON")


class Example(NamedTuple):
    payload: str
    parameters: str
    gives: str


def examples() -> list[Example]:
    """The payloads of the page, each with the parameters behind it and what they make of it."""
    blocks = [block for block in BLOCKS.values() if block.page == PAGE]
    starts = [n for n, block in enumerate(blocks) if block.says == "payload"]
    return [Example(*(block.text for block in blocks[n : n + 3])) for n in starts]


def shown(sample: Sample) -> str:
    groups = {name: getattr(sample, name) for name in GROUPS}
    parts = [
        f"{name} {' '.join(f'{number:.6g}' for number in numbers)}"
        for name, numbers in groups.items()
        if numbers is not None
    ]
    if sample.device_time_ns is not None:
        date = datetime.fromtimestamp(sample.device_time_ns / 1e9, timezone.utc)
        parts.append(date.isoformat(timespec="microseconds"))
    return ", ".join(parts)


@pytest.mark.parametrize("example", examples(), ids=lambda example: example.gives[:30])
def test_an_example_gives_what_the_page_says(example: Example, tmp_path: Path) -> None:
    file = tmp_path / "imu.toml"
    file.write_text(example.parameters)
    assert parse_toml(example.parameters)
    specs = reader_parameters(installed_plugins())
    values = {spec.name: spec.default for spec in specs} | check_given(specs, read_given([], file))
    settings = read_settings(installed_plugins(), values.__getitem__)
    assert not settings.without_effect
    read = settings.mapping.compile(device_time=settings.uses_device_time)
    found = read(example.payload.encode())
    samples = found.samples if isinstance(found, Batch) else [found]
    lines = []
    for sample in samples:
        assert not isinstance(sample, Reject), sample
        assert not sample.left_out
        lines.append(shown(sample))
    assert lines == example.gives.splitlines()


def test_there_is_an_example_for_each_kind_of_payload() -> None:
    assert len(examples()) >= len(KINDS)
    page = PAGE.read_text()
    for kind in KINDS:
        section = page.partition(f"### {kind}\n")[2].partition("\n### ")[0]
        assert "<!-- gives -->" in section, kind


def test_the_page_names_every_reason_of_a_mapping() -> None:
    page = PAGE.read_text()
    for reason in [*PAYLOAD_REASONS, "no_imu_data"]:
        assert f"`{reason}`" in page, reason
