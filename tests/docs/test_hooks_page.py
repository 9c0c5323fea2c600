"""The page of hooks names every hook and every field of a descriptor, exactly as they are."""

import inspect
import re
from pathlib import Path
from typing import Any, get_args, get_type_hints

import pytest

from rosbase.parameters import ParameterValue
from rosbase.plugins import CommandPlugin, PluginRegistry, hookspec
from support.code_blocks import BLOCKS, ROOT, blocks_of
from support.plugins import candidates_in, install_plugin

PAGE = "docs/plugins/hooks.md"
TEXT = (ROOT / PAGE).read_text()
SECTIONS = dict(re.findall(r"^## `(\w+)`\n(.*?)(?=^## |\Z)", TEXT, re.M | re.S))
HOOKS = {
    name: hook
    for name, hook in vars(hookspec).items()
    if name.startswith(hookspec.HOOK_PREFIX) and inspect.isfunction(hook)
}


def written(annotation: Any) -> str:
    """The type as the page writes it: without modules, and with the name of the union of values."""
    text = inspect.formatannotation(annotation).replace(str(ParameterValue), "ParameterValue")
    return re.sub(r"\b(?:\w+\.)+(?=\w)", "", text)


def descriptor_of(hook: str) -> type:
    (descriptor,) = get_args(get_type_hints(HOOKS[hook])["return"])
    assert isinstance(descriptor, type)
    return descriptor


def rows_of(hook: str) -> list[list[str]]:
    """The rows of its table, the head included, each cell without its backticks."""
    lines = [line for line in SECTIONS[hook].splitlines() if line.startswith("|")]
    cells = [re.split(r"(?<!\\)\|", line.strip("|")) for line in lines]
    return [[cell.strip().strip("`").replace("\\|", "|") for cell in line] for line in cells]


def test_every_hook_has_a_section_and_no_section_is_of_none() -> None:
    assert HOOKS.keys() == SECTIONS.keys()


@pytest.mark.parametrize("hook", HOOKS)
def test_a_hook_is_shown_with_its_signature(hook: str) -> None:
    signature = inspect.signature(HOOKS[hook])
    arguments = ", ".join(signature.parameters)
    shown = f"`{hook}({arguments}) -> {written(signature.return_annotation)}`"
    assert SECTIONS[hook].strip().splitlines()[0] == shown


@pytest.mark.parametrize("hook", HOOKS)
def test_a_descriptor_is_shown_with_every_field_its_type_and_its_default(hook: str) -> None:
    descriptor = descriptor_of(hook)
    head, _, *rows = rows_of(hook)
    assert head[0] == descriptor.__name__
    required = inspect.Parameter.empty
    expected = [
        [p.name, written(p.annotation), "required" if p.default is required else repr(p.default)]
        for p in inspect.signature(descriptor).parameters.values()
    ]
    assert [row[:3] for row in rows] == expected
    assert all(row[3] for row in rows)


@pytest.fixture
def registry(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> PluginRegistry:
    """What the plugins of the page become when they are installed."""
    monkeypatch.syspath_prepend(tmp_path)
    for block in blocks_of(PAGE, "python"):
        name = block.file.removesuffix(".py")
        install_plugin(tmp_path, f"the-{name}", name, block.text)
    return PluginRegistry(candidates_in(tmp_path))


def test_the_plugins_of_the_page_can_be_installed(registry: PluginRegistry) -> None:
    assert [record.failure for record in registry.plugins] == ["", ""]
    assert set(registry.presets) == {"shop_imu"}
    assert isinstance(registry.commands["hello"], CommandPlugin)


def test_the_entry_point_of_the_page_is_in_the_group_that_is_searched() -> None:
    (shown,) = [b for b in BLOCKS.values() if b.page == ROOT / PAGE and b.kind == "toml"]
    assert "[project.entry-points.rosbase]" in shown.text
