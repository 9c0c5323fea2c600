"""What contributors are told agrees with what is checked: versions, tools, sessions, links."""

import ast
import re
from pathlib import Path
from typing import Any

import pytest

from rosbase.text.toml import parse_toml

ROOT = Path(__file__).parents[2]
PACKAGES = sorted(path.parent for path in ROOT.glob("packages/*/pyproject.toml"))
NOXFILE = (ROOT / "noxfile.py").read_text()
WORKFLOW = (ROOT / ".github/workflows/ci.yml").read_text()
PRE_COMMIT = (ROOT / ".pre-commit-config.yaml").read_text()
PINNED = re.compile(r"\"([\w-]+)==([\d.]+)\"")


def project(package: Path) -> dict[str, Any]:
    found: dict[str, Any] = parse_toml((package / "pyproject.toml").read_text())["project"]
    return found


def latest(changelog: Path) -> str:
    """The version that its first section is about."""
    found = re.search(r"^## (\S+)", changelog.read_text(), re.M)
    assert found, changelog
    return found[1]


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.name)
def test_a_distributions_version_is_that_of_its_changelog_and_readme(package: Path) -> None:
    version = project(package)["version"]
    assert project(package)["name"] == package.name
    assert latest(package / "CHANGELOG.md") == version
    for page in (package / "README.md", ROOT / "README.md"):
        assert set(re.findall(rf"{package.name}[ =]+(\d+\.\d+\.\d+)", page.read_text())) <= {
            version
        }
    for manifest in package.glob("package.xml"):
        assert f"<version>{version}</version>" in manifest.read_text()


def test_the_changelog_of_the_whole_names_every_distribution_and_the_latest_release() -> None:
    page = (ROOT / "CHANGELOG.md").read_text()
    for package in PACKAGES:
        assert f"(packages/{package.name}/CHANGELOG.md)" in page
    assert latest(ROOT / "CHANGELOG.md") == max(project(package)["version"] for package in PACKAGES)


def test_pre_commit_has_the_tools_of_nox_in_the_same_versions() -> None:
    of_nox, of_hooks = dict(PINNED.findall(NOXFILE)), PINNED.findall(PRE_COMMIT)
    assert {name for name, _ in of_hooks} == {"ruff"}
    assert all(of_nox[name] == version for name, version in of_hooks)
    assert set(re.findall(r"nox>=([\d.]+)", NOXFILE + PRE_COMMIT)) == set(
        re.findall(r"needs_version = \">=([\d.]+)\"", NOXFILE)
    )


def sessions() -> dict[str, str]:
    """The sessions that `nox` runs, by name, with the Python that each asks for."""
    found = {}
    for node in ast.parse(NOXFILE).body:
        if isinstance(node, ast.FunctionDef):
            marks = [ast.unparse(mark) for mark in node.decorator_list]
            mark = next((mark for mark in marks if mark.startswith("nox.session")), "")
            if mark and "default=False" not in mark:
                found[node.name] = "all" if "python=PYTHONS)" in mark else "one"
    return found


def run_by(job: str) -> set[str]:
    steps = WORKFLOW.split(f"\n  {job}:\n")[1].split("\n  once:\n")[0]
    (named,) = re.findall(r"nox .*--sessions (.+)", steps)
    return set(named.split())


def test_the_workflow_runs_every_session_of_nox_and_every_python_where_it_matters() -> None:
    of_nox = sessions()
    assert run_by("tests") == {name for name, pythons in of_nox.items() if pythons == "all"}
    assert run_by("once") == {name for name, pythons in of_nox.items() if pythons == "one"}
    assert f'python: ["{oldest_python()}", "3.11", "3.12", "3.13"]' in WORKFLOW
    assert "mosquitto" in WORKFLOW


def oldest_python() -> str:
    (asked,) = {project(package)["requires-python"] for package in PACKAGES}
    return str(asked).removeprefix(">=")


def test_every_tool_and_every_project_of_the_documentation_has_the_oldest_python() -> None:
    oldest, tools = oldest_python(), parse_toml((ROOT / "pyproject.toml").read_text())["tool"]
    assert tools["ruff"]["target-version"] == f"py{oldest.replace('.', '')}"
    assert tools["mypy"]["python_version"] == oldest
    for project in (
        "docs/examples/udp/pyproject.toml",
        "docs/template/project/pyproject.toml.jinja",
    ):
        assert f'requires-python = ">={oldest}"' in (ROOT / project).read_text()
    for file in (NOXFILE, (ROOT / ".ci/run").read_text()):
        assert f"Python from {oldest} up" in file
    programs, checks = (
        "tests/check_programs.py",
        "packages/rosbase-core/src/rosbase/cli/core_checks.py",
    )
    assert f'OLDEST_PYTHON = "{oldest}"' in (ROOT / programs).read_text()
    assert f"use CPython {oldest} or newer" in (ROOT / checks).read_text()


def test_the_sessions_that_contributors_are_told_of_exist() -> None:
    page = (ROOT / "CONTRIBUTING.md").read_text()
    # Those that run only when they are asked for, too.
    defined = set(re.findall(r"^def (\w+)\(session: nox\.Session\)", NOXFILE, re.M))
    for named in re.findall(r"nox -s ([a-z ]*[a-z])", page + PRE_COMMIT):
        assert set(named.split()) <= defined


PAGES = [*ROOT.glob("*.md"), *ROOT.glob(".github/**/*.md"), *ROOT.glob("packages/*/*.md")]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_what_a_page_links_to_is_there_and_no_address_is_made_up(page: Path) -> None:
    text = page.read_text()
    for target in re.findall(r"\]\(([^)#]+)", text):
        assert target == "https://semver.org" or (page.parent / target).exists(), target
    assert not re.search(r"[\w.]+@[\w-]+\.\w", text)


@pytest.mark.parametrize("kind", ["bug", "feature", "plugin"])
def test_an_issue_template_has_a_name_and_says_what_it_is_about(kind: str) -> None:
    head = (ROOT / f".github/ISSUE_TEMPLATE/{kind}.md").read_text().split("---")[1]
    assert re.findall(r"^(\w+):", head, re.M) == ["name", "about", "labels"]
