"""What the site shows of the code is all of it. That it can be built, `nox -s docs` shows."""

import ast
import pkgutil
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from sphinx.project import Project

import rosbase
from generators import capabilities, conformance, docstrings, lifecycle, public
from rosbase.lifecycle import TRANSITIONS, State
from rosbase.plugins import PresetPlugin, installed_plugins
from rosbase.testing import TransportCapabilities
from support.code_blocks import BLOCKS, PAGES, ROOT

DOCS = ROOT / "docs"
API = "".join(page.read_text() for page in DOCS.glob("reference/api/*.rst"))
# What neither programs nor plugins are meant to import.
INTERNAL = {
    *(
        "__main__",
        "cli",
        "contracts.guarded_services",
        "contracts.node_view",
        "contracts.recorded_answers",
        "contracts.stored_parameters",
    ),
    *("entries", "imu", "local", "program"),
    *(
        "roles.callables",
        "roles.change_times",
        "roles.classes",
        "roles.connection",
        "roles.construction",
        "roles.context",
        "roles.keywords",
        "roles.lookup",
        "roles.program",
        "roles.recording",
        "roles.registration",
        "roles.set_by_constructor",
        "roles.shutdown",
        "roles.transition_entrance",
        "roles.transitions",
        "runtime.early_wake",
        "runtime.stopping",
        "runtime.waiting",
        "text.toml",
        "text.yaml_flow",
        "text.yaml_text",
    ),
}
ROOMS = ("contracts", "roles", "runtime", "text")

REGISTRY = installed_plugins()
TABLES = capabilities.tables(REGISTRY)


def test_what_tools_leave_in_a_folder_is_no_page(tmp_path: Path) -> None:
    patterns = re.search(r"^exclude_patterns = (\[.*\])$", (DOCS / "conf.py").read_text(), re.M)
    assert patterns is not None
    kept, left = tmp_path / "how-to" / "page.md", tmp_path / "examples/udp/.pytest_cache/README.md"
    for path in (kept, left):
        path.parent.mkdir(parents=True)
        path.write_text("# A page")
    found = Project(tmp_path, {".md": "markdown"}).discover(ast.literal_eval(patterns[1]))
    assert found == {"how-to/page"}


def test_every_module_for_programs_and_plugins_is_in_the_api() -> None:
    root = Path(rosbase.__file__).parent
    modules = {module.name for module in pkgutil.iter_modules(rosbase.__path__)} - {*ROOMS}
    for room in ROOMS:
        modules |= {f"{room}.{module.name}" for module in pkgutil.iter_modules([str(root / room)])}
    shown = set(re.findall(r"automodule:: rosbase\.([\w.]+)$", API, re.M))
    # Of these modules, users need some classes only.
    shown |= set(re.findall(r"autoclass:: rosbase\.([a-z_.]+)\.[A-Z]\w+$", API, re.M))
    assert modules - INTERNAL == {
        name
        for name in shown
        if not name.startswith(
            ("control.", "imu.", "testing.", "local", "messages.", "utils.", "wire.")
        )
    }


def test_every_public_name_is_on_the_page_that_lists_them_with_a_summary() -> None:
    # Each is a link, and a link that leads nowhere ends the build.
    rows = re.findall(r"\| \{py:obj\}`rosbase\.(\w+)` \| (.+?) \|$", public.tables(), re.M)
    assert sorted(name for name, _ in rows) == sorted(rosbase.__all__)


def test_a_public_name_does_not_depend_on_where_it_is_defined() -> None:
    allowed = {
        "rosbase",
        *(
            f"rosbase.{name}"
            for name in ("messages", "wire", "fsm", "lifecycle", "control", "testing", "utils")
        ),
    }
    sources = [*PAGES, *ROOT.glob("docs/examples/**/*.py"), *ROOT.glob("docs/template/**/*.jinja")]
    for source in sources:
        for module in re.findall(
            r"^\s*(?:from|import) (rosbase\b[\w.]*)", source.read_text(), re.M
        ):
            # Those of ROS packages.
            assert module in allowed or module.startswith("rosbase.messages."), source


def test_the_drawing_has_every_state_and_every_transition() -> None:
    drawing = ElementTree.fromstring(lifecycle.diagram())
    texts = [text.text for text in drawing.iter("{http://www.w3.org/2000/svg}text")]
    assert {state.label for state in State if state is not State.UNKNOWN} <= set(texts)
    arrows = [path.get("data-id") for path in drawing.iter("{http://www.w3.org/2000/svg}path")]
    assert set(filter(None, arrows)) == {str(transition.id) for transition in TRANSITIONS}
    assert {t.label for t in TRANSITIONS if t.is_public} <= set(texts)


def test_the_table_has_every_transition_in_order() -> None:
    rows = lifecycle.table().splitlines()[2:]
    assert [row.split("|")[1].strip() for row in rows] == [str(t.id) for t in TRANSITIONS]


@pytest.mark.parametrize("kind", ["backends", "transports", "presets", "checks"])
def test_every_installed_plugin_is_among_the_capabilities(kind: str) -> None:
    for name, found in getattr(REGISTRY, kind).items():
        assert f"| `{name}` | {found.summary} |" in TABLES


def test_a_transports_capabilities_are_what_it_declares() -> None:
    head, row = (
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in TABLES.split("## Transports\n")[1].split("\n## ")[0].splitlines()
        if line.startswith(("| transport |", "| `serial` |"))
    )
    shown = dict(zip(head, row, strict=True))
    assert shown["which device"] == "`device_path`"
    assert (shown["`simulate`"], shown["wheel"]) == ("yes", "imu-serial")


def test_what_implementations_declare_to_the_kit_is_read_off_their_tests() -> None:
    shown = conformance.tables()
    tests = {path.relative_to(ROOT).as_posix() for path in ROOT.glob("tests/*/test_*_contract.py")}
    parts = {
        "tests/core/test_line_framer_contract.py",
        "tests/core/test_device_transport_contract.py",
        # The transport of the core, as a recorded program has it.
        "tests/core/test_device_conducted_contract.py",
    }
    assert tests - parts <= set(conformance.TESTS)
    for path in conformance.TESTS:
        assert f"| {conformance.title_of(path)} |" in shown
    serial = TransportCapabilities(is_stream=True, can_unplug=True, can_be_absent=True)
    (row,) = (line for line in shown.splitlines() if line.startswith("| `serial` |"))
    assert row.startswith("| `serial` | yes | yes | yes | `{'wait_for_device': True}` | yes |")
    assert row.endswith(f" `{serial.frames_lost_after_junk}` |")


def test_every_parameter_of_a_transport_is_among_the_capabilities() -> None:
    for transport in REGISTRY.transports.values():
        section = TABLES.split(f"## Parameters of the transport `{transport.name}`\n")[1]
        for spec in transport.parameters:
            assert f"| `{spec.name}` |" in section.split("\n## ")[0]


def test_a_bar_in_a_description_does_not_end_its_cell() -> None:
    preset = PresetPlugin("odd", "left|right", {})
    assert "left\\|right" in capabilities.table(["preset"], [[preset.summary]])


def test_a_line_of_a_program_fits_a_page_of_1280_pixels() -> None:
    # Commands and output are wrapped (docs/static/pages.css).
    for name, block in BLOCKS.items():
        if block.kind not in ("bash", "ini", "json", "text"):
            assert max(map(len, block.text.splitlines())) <= 100, name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_leads_to_a_file(page: Path) -> None:
    for link in re.findall(r"\]\(([^)#\s]+)", page.read_text()):
        assert "://" in link or (page.parent / link).exists(), link


def prepared(text: str, what: str = "class") -> list[str]:
    lines = text.splitlines()
    docstrings.prepare(None, what, "name", None, None, lines)
    return lines


def test_indented_and_fenced_lines_of_a_docstring_are_code() -> None:
    assert prepared("Text.\n\n    x = 1\n\n        y\n\nMore.") == [
        *("Text.", "", "::", "", "    x = 1", "", "        y", "", "More.")
    ]
    assert prepared("Text.\n\n```\nx\n```") == ["Text.", "", "::", "", "    x", ""]


def test_a_section_of_a_docstring_is_no_code() -> None:
    text = "Text.\n\nArgs:\n    x: One.\n\nRaises:\n    ValueError: Two."
    assert prepared(text) == text.splitlines()


def test_the_text_of_a_field_is_no_type() -> None:
    assert prepared("When: now.", "attribute") == ["\\", "When: now."]
    assert prepared("When: now.") == ["When: now."]
