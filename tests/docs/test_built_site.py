"""The built site: its search, its navigation, and what a page may not show."""

import json
import re
from html import unescape
from pathlib import Path
from typing import Any

import pytest

# Whichever worker comes first builds the site.
pytestmark = pytest.mark.timeout(300)

FEATURES = "features"
# What a reader may look for, and the page that the search has to show first.
LOOKED_FOR = {
    **dict.fromkeys(
        (
            *("topics between programs", "images", "parameters", "services", "recording", "plots"),
            *("launching", "joystick", "asyncio", "real time", "Windows", "macOS", "cameras", "tf"),
            *("publishing from the command line", "publish from the command line"),
            *("actions", "rosbag", "transforms", "threads", "simulation"),
        ),
        FEATURES,
    ),
    "log files": "logging",
    "rclpy": "how-to/from-rclpy",
    "task state machine": "how-to/task-state-machines",
    "own messages": "how-to/messages",
    "loop_stats": "how-to/main-loop-timing",
}
TITLES = {
    "architecture": "design",
    "pick and place": "examples/pick_place/README",
    "a quadruped": "examples/quadruped/README",
    "imu-udp": "examples/udp/README",
    "task state machines": "how-to/task-state-machines",
}
LONGEST_SIGNATURE = 1_500


@pytest.fixture(scope="module")
def index(site: Path) -> Any:
    """What the search of the site reads."""
    text = (site / "searchindex.js").read_text()
    return json.loads(text.removeprefix("Search.setIndex(").removesuffix(")"))


def pages_of(site: Path) -> list[Path]:
    return [page for page in site.rglob("*.html") if "_static" not in page.parts]


def text_of(html: str) -> str:
    return unescape(re.sub(r"<[^>]+>", "", html))


@pytest.mark.parametrize("words", LOOKED_FOR)
def test_the_search_shows_the_page_about_it_first(words: str, index: Any) -> None:
    # Entries of the index that are main ones come before whatever else is found.
    found = [
        index["docnames"][page]
        for page, _, is_main in index["indexentries"][words.lower()]
        if is_main
    ]
    assert found[0] == LOOKED_FOR[words]


@pytest.mark.parametrize("title", TITLES)
def test_a_page_has_the_title_that_a_reader_looks_for(title: str, index: Any) -> None:
    titles = {text.lower(): number for number, text in enumerate(index["titles"])}
    assert index["docnames"][titles[title]] == TITLES[title]


def test_every_thing_of_the_features_has_a_row_that_says_where_it_is(site: Path) -> None:
    page = (site / f"{FEATURES}.html").read_text()
    rows = [re.findall(r"<td>(.*?)</td>", row, re.S) for row in page.split("<tr")[1:]]
    verdicts = [(text_of(row[0]), text_of(row[1]).strip()) for row in rows if row]
    assert {verdict for _, verdict in verdicts} == {"rosbase", "ROS", "no"}
    things = " ".join(thing.lower() for thing, _ in verdicts)
    for thing in (
        *("topics between", "images", "parameters", "services", "recording", "plots", "launching"),
        *("joystick", "asyncio", "real time", "windows", "macos", "cameras", "tf", "log files"),
        "publish from the command line",
    ):
        assert thing in things


def test_no_value_and_no_signature_of_the_api_is_endless(site: Path) -> None:
    for page in site.glob("reference/api/*.html"):
        for signature in re.findall(r'<dt class="sig.*?</dt>', page.read_text(), re.S):
            assert len(text_of(signature)) < LONGEST_SIGNATURE, page


def test_the_api_shows_what_programs_use_of_the_roles_and_no_internals(site: Path) -> None:
    page = (site / "reference/api/roles.html").read_text()
    shown = set(re.findall(r'<dt class="sig[^>]* id="rosbase\.[\w.]*?\.(\w+\.\w+)"', page))
    for name in ("nodes", "agents", "handlers", "logger", "backend", "loop_stats", "state"):
        assert f"BaseManager.{name}" in shown
    for role in ("BaseNode", "BaseAgent", "BaseHandlers"):
        for name in ("manager", "nodes", "agents", "logger", "timestamp"):
            assert f"{role}.{name}" in shown
    assert {"LoopStats.period", "LoopStats.busy", "Histogram.percentile"} <= shown
    assert not shown & {"LoopStats.notes", "LoopStats.digest", "Histogram.record"}
    assert not [name for name in shown if name.startswith(("Component.", "ManagerContext."))]


def test_reference_authors_and_maintainers_are_groups_of_the_navigation(site: Path) -> None:
    page = (site / "index.html").read_text()
    tree = page.split('class="sidebar-tree"')[1].split("</aside>")[0]
    _, *groups = re.split(r'<p class="caption"[^>]*>', tree)
    found = {
        text_of(group.split("</p>")[0]).strip(): set(re.findall(r'href="([^"#]+)"', group))
        for group in groups
    }
    assert {"reference/index.html", "features.html"} <= found["Reference"]
    assert {"examples/pick_place/README.html"} <= found["Examples"]
    assert found["For maintainers"] == {"design.html"}
    assert not any("design.html" in pages for name, pages in found.items() if "maint" not in name)


def test_every_mermaid_diagram_is_drawn_in_the_colours_of_the_page(site: Path) -> None:
    for page in ("how-to/task-state-machines", "examples/pick_place/README"):
        html = (site / f"{page}.html").read_text()
        (drawn,) = re.findall(r'<div class="diagram">(<svg.*?</svg>)</div>', html, re.S)
        assert "currentColor" in drawn
        assert not re.findall(r'"#[0-9A-Fa-f]{6}"', drawn)
    assert not [page for page in pages_of(site) if "highlight-mermaid" in page.read_text()]
    states = re.findall(r">([A-Z_]{4,})</text>", drawn)
    assert {"WAIT_FOR_PICK_TARGET", "AI_CONFIRM_PICK", "FINISHED"} <= set(states)


def test_code_has_a_copy_button_and_no_page_needs_the_network(site: Path) -> None:
    assert (site / "_static/copybutton.js").exists()
    for page in pages_of(site):
        html = page.read_text()
        assert "copybutton.js" in html, page
        assert not re.findall(r'<(?:script|link|img)[^>]+(?:src|href)="https?:', html), page
