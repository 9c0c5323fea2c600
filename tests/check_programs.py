"""Checks the types of every documented program: `mypy --strict`, and pyright without settings.

The programs are the Python blocks of the pages, the examples, and the template for a plugin:
as it is rendered, and as its page fills it in.
"""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from copier import run_copy

from support.code_blocks import BLOCKS, ROOT

EXAMPLES = sorted((ROOT / "docs/examples").glob("*/"))
# The page compares a program for ros_base, which has no annotations, with the same on rosbase.
UNTYPED = {"docs/migrating-from-ros_base.md"}
# As mypy's in pyproject.toml.
OLDEST_PYTHON = "3.10"
# rclpy has no types, and launch is not in the package index.
UNTYPED_FILES = {"limiter_rclpy.py", "limiter.launch.py"}


def main(arguments: list[str]) -> int:
    """Write the programs into a folder, check them, and return the exit status."""
    folder = Path(arguments[0]).resolve()
    shutil.rmtree(folder, ignore_errors=True)
    projects = [
        *write_pages(folder),
        render_template(folder / "rendered"),
        fill_in(render_template(folder / "filled_in")),
        # Copies, because pyright is told about all of them by one file.
        *(Path(shutil.copytree(example, folder / example.name)) for example in EXAMPLES),
    ]
    statuses = [run_mypy(project) for project in projects]
    return max(*statuses, run_pyright(folder, projects))


def write_pages(folder: Path) -> list[Path]:
    """Write each page's programs into one folder, which pages share unless a name is taken."""
    pages: dict[str, dict[str, str]] = {}
    for name, block in BLOCKS.items():
        if block.kind == "python" and not block.title:
            page = block.page.relative_to(ROOT).as_posix()
            file = block.file or re.sub(r"\W", "_", name) + ".py"
            if file not in UNTYPED_FILES:
                pages.setdefault(page, {})[file] = block.text
    projects: list[Path] = []
    for files in (files for page, files in pages.items() if page not in UNTYPED):
        free = (p for p in projects if not any((p / file).exists() for file in files))
        if (project := next(free, None)) is None:
            project = folder / f"pages_{len(projects) + 1}"
            project.mkdir(parents=True)
            projects.append(project)
        for file, text in files.items():
            (project / file).write_text(text)
    return projects


def render_template(folder: Path) -> Path:
    """Render the template for a plugin, for a transport `tcp`."""
    run_copy(str(ROOT / "docs/template"), folder, {"name": "tcp"}, defaults=True, quiet=True)
    return folder


def fill_in(project: Path) -> Path:
    """Write into a rendered template what its page shows of each file."""
    for block in BLOCKS.values():
        if block.title:
            (file,) = project.rglob(block.title)
            file.write_text(block.text)
    return project


def run_mypy(project: Path) -> int:
    """Run mypy on one project, from whose folder its modules are imported."""
    path = os.pathsep.join(map(str, [project, project / "src"]))
    config = ["--config-file", str(ROOT / "pyproject.toml"), "--strict"]
    command = [sys.executable, "-m", "mypy", *config, str(project)]
    return subprocess.run(command, env={**os.environ, "MYPYPATH": path}, check=False).returncode


def run_pyright(folder: Path, projects: list[Path]) -> int:
    """Run pyright once on all projects: most of its time is its start."""
    roots = [{"root": project.name, "extraPaths": [f"{project.name}/src"]} for project in projects]
    config = {
        "typeCheckingMode": "standard",
        "pythonVersion": OLDEST_PYTHON,
        "executionEnvironments": roots,
    }
    (folder / "pyrightconfig.json").write_text(json.dumps(config))
    options = ["--warnings", "--pythonpath", sys.executable, "--project", str(folder)]
    return subprocess.run([sys.executable, "-m", "pyright", *options], check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
