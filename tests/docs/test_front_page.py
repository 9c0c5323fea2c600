"""The front page and the README: their pictures, their facts, their commands."""

import re
from collections.abc import Iterator
from xml.etree import ElementTree

import pytest

import rosbase
from generators import demo, facts, pictures, roles, terminal, view
from rosbase.plugins import installed_plugins
from rosbase.text.toml import parse_toml
from support.code_blocks import PAGES, ROOT, blocks_of

README = (ROOT / "README.md").read_text()
FRONT = (ROOT / "docs/index.md").read_text()
BOTH = {"README.md": README, "docs/index.md": FRONT}
DEMO, ROLES = (pictures.FOLDER / name for name in ("demo.svg", "roles.svg"))
ANEW = "run `nox -s pictures`"
SVG = "{http://www.w3.org/2000/svg}"
PROJECTS = [
    parse_toml(path.read_text())["project"] for path in ROOT.glob("packages/*/pyproject.toml")
]


def texts(picture: str) -> list[str]:
    """The rows of a drawn screen, with spaces for bars."""
    rows: dict[str, list[str]] = {}
    for text in ElementTree.fromstring(picture).iter(f"{SVG}text"):
        rows.setdefault(text.attrib["y"], []).append(text.text or "")
    return [" ".join(parts) for parts in rows.values()]


def without_numbers(rows: list[str]) -> list[str]:
    named = (re.sub(r"/tmp/imu-\w+/", "/tmp/imu-0/", row) for row in rows)
    return [re.sub(r"[+-]?\d+(\.\d+)?", "0", row) for row in named]


def drawn(*parts: str, columns: int = 40) -> str:
    """What the terminal shows of a text that printf writes."""
    written = terminal.run("printf", *parts, columns=columns)
    return terminal.draw(terminal.last_screen(written, columns), "it")


def test_the_demo_of_the_readme_is_what_the_command_shows_up_to_the_numbers() -> None:
    frames, rows = [], []
    for picture in (DEMO.read_text(), demo.picture()):
        frames.append(without_numbers(re.findall(r"^<(?:svg|title|g).*", picture, re.M)))
        rows.append(texts(picture))
    shown, real = rows
    assert without_numbers(shown) == without_numbers(real), ANEW
    assert frames[0] == frames[1], ANEW
    assert shown[0] == "$ rosbase demo --duration 5"
    (verdict,) = (row for row in shown if row.startswith("All "))
    assert "although it was unplugged" in verdict
    assert shown[-1].startswith("Try next: rosbase ")


def test_a_page_has_the_demo_for_wide_windows_and_for_narrow_ones() -> None:
    wide, narrow = (f"{part}</svg>" for part in demo.pictures().split("</svg>\n")[:2])
    assert "demo-wide" in wide
    assert "demo-narrow" in narrow
    widths = [float(re.findall(r'viewBox="0 0 (\d+)', picture)[0]) for picture in (wide, narrow)]
    assert widths[1] < 0.65 * widths[0]
    for picture in (wide, narrow):
        assert "nothing lost" in " ".join(texts(picture))
    # A blank line would end it in Markdown.
    assert "\n\n" not in wide + narrow


def test_the_front_page_shows_the_view_of_a_simulated_imu() -> None:
    assert "<!-- generated: view -->" in FRONT
    picture = view.picture()
    rows = texts(picture)
    assert rows[0].startswith("[1 topics]")
    assert any("/imu/data" in row and " Hz" in row for row in rows)
    assert any(row.startswith("roll ") for row in rows)
    # The board is drawn with dots.
    assert picture.count("<path") > 20
    assert "q quit" in rows[-1]
    assert "\n\n" not in picture


def test_the_roles_of_the_readme_are_those_of_the_site() -> None:
    assert ROLES.read_text() == roles.picture(), ANEW


def test_the_drawing_names_the_four_roles_and_their_classes() -> None:
    drawing = ElementTree.fromstring(roles.diagram())
    words = "".join(drawing.itertext())
    for role in ("Manager", "Node", "Agent", "Handlers"):
        assert f"{role}Base{role}" in words
        assert hasattr(rosbase, f"Base{role}")
        assert all(f"Base{role}" in page for page in BOTH.values())
    assert "handle()" in words


def test_the_parts_of_the_drawing_lie_inside_and_roles_inside_the_manager() -> None:
    manager, *others = roles.ROLES
    for box in others:
        assert manager.x < box.x
        assert box.x + box.width < manager.x + manager.width
        assert manager.y < box.y
        assert box.y + box.height < manager.y + manager.height
    assert manager.y + manager.height < roles.HEIGHT


def test_the_drawing_of_the_readme_has_colours_for_light_and_dark() -> None:
    assert "prefers-color-scheme:dark" in roles.picture()
    # On a page a style sheet would count for the whole page, which has its own switch.
    assert "<style" not in roles.diagram()
    assert 'fill="currentColor"' in roles.diagram()


def test_colours_and_bars_of_a_terminal_are_drawn() -> None:
    picture = drawn("\\033[2mgrey\\033[0m  two words \\033[36m│█▌\\033[0m\\nnext")
    assert texts(picture) == ["grey two words", "next"]
    assert picture.count("<rect") == 4
    assert picture.count('fill="#4cc2d6"') == 3
    assert re.search(r'fill="#8b95a5">grey<', picture)


def test_sparklines_dots_rules_and_chosen_rows_of_a_terminal_are_drawn() -> None:
    picture = drawn("▁▇ ⠁ ───\\n\\033[7mchosen\\033[0m")
    assert texts(picture) == ["chosen"]
    heights = [
        float(height)
        for height in re.findall(r'width="8.45" height="([\d.]+)" fill="#d4dae3"', picture)
    ]
    assert heights == [2.4, 16.6]
    assert picture.count("<path") == 1
    assert 'height="1.0"' in picture
    assert re.search(r'fill="#171a21">chosen<', picture)


def test_markup_that_a_command_writes_is_text() -> None:
    assert texts(drawn("<b> & c")) == ["<b> & c"]


def test_what_was_written_over_is_not_drawn() -> None:
    assert texts(drawn("first\\nold\\033[1A\\r\\033[Jnew")) == ["new"]


def test_a_command_that_fails_ends_the_build() -> None:
    with pytest.raises(RuntimeError, match="status 1"):
        terminal.run("false", columns=40)


def test_the_facts_are_those_of_the_packages() -> None:
    line, *_ = facts.facts().split(" · [Repository]")
    assert line in README
    assert "<!-- generated: facts -->" in FRONT
    for project in PROJECTS:
        assert f"Python {project['requires-python'].removeprefix('>=')} or newer" in line
        assert project["license"] in line
        assert "Operating System :: POSIX :: Linux" in project["classifiers"]
        assert f"Version {project['version']}" in line


def test_no_page_asks_for_another_python_or_another_machine() -> None:
    oldest = PROJECTS[0]["requires-python"].removeprefix(">=")
    for page in PAGES:
        text = " ".join(page.read_text().split())
        asked = re.findall(r"Python (?:from )?(3\.\d+)(?= or| up|\+)", text)
        assert set(asked) <= {oldest}, page
        assert "any machine with" not in text, page


@pytest.mark.parametrize(
    ("remote", "address"),
    [
        ("https://example.org/team/rosbase.git", "https://example.org/team/rosbase"),
        ("https://me:secret@example.org/team/rosbase", "https://example.org/team/rosbase"),
        ("git@example.org:team/rosbase.git", "https://example.org/team/rosbase"),
        ("ssh://git@example.org:2222/team/rosbase", "https://example.org/team/rosbase"),
        ("/srv/git/rosbase.git", ""),
        ("file:///srv/git/rosbase.git", ""),
        ("", ""),
    ],
)
def test_the_repository_is_where_the_clone_comes_from(remote: str, address: str) -> None:
    assert facts.web_address(remote) == address


def commands_in(page: str) -> Iterator[str]:
    yield from re.findall(r"(?:`|^|&& )rosbase ([a-z]+)", page, re.M)


@pytest.mark.parametrize("name", BOTH)
def test_every_command_that_is_named_exists(name: str) -> None:
    named = set(commands_in(BOTH[name]))
    assert {"demo", "simulate", "doctor"} <= named
    assert named <= set(installed_plugins().commands)


def test_the_readme_and_the_front_page_show_the_same_program() -> None:
    (front,) = blocks_of("docs/index.md", "python")
    assert blocks_of("README.md", "python")[0].text == front.text


@pytest.mark.parametrize("topic", ["Comparison with rclpy and launch", "Limits"])
def test_the_readme_and_the_front_page_say_the_same(topic: str) -> None:
    sections = {page.split(f"## {topic}\n")[1].split("\n## ")[0] for page in BOTH.values()}
    assert len(sections) == 1
