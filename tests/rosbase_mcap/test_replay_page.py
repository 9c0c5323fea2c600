"""The guide on replays: its commands and its test, beside the program that it shows."""

import os
import subprocess
import sys
from pathlib import Path

from support.code_blocks import BLOCKS, ROOT, write_files
from support.command import ROSBASE

PAGE = ROOT / "docs/how-to/replay.md"


def test_the_commands_and_the_test_of_the_page_replay_its_program(tmp_path: Path) -> None:
    write_files(PAGE, tmp_path, "")
    wanted = "--record field.mcap robot.py"
    [block] = [b for b in BLOCKS.values() if b.page == PAGE and wanted in b.text]
    commands = [[ROSBASE, *line.split()[1:]] for line in block.text.splitlines()]
    commands.append([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"])
    said = ""
    for command in commands:
        done = subprocess.run(
            command,
            cwd=tmp_path,
            # As a user has it who has not read all of the page.
            env={name: text for name, text in os.environ.items() if name != "PYTHONHASHSEED"},
            capture_output=True,
            text=True,
            timeout=50,
            check=False,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        said += done.stdout + done.stderr
    assert "no difference: " in said
    assert "1 passed" in said
