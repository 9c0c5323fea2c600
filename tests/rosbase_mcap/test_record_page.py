"""The guide on recordings: its commands, beside the program that it shows."""

import subprocess
from pathlib import Path

from support.code_blocks import BLOCKS, ROOT, write_files
from support.command import ROSBASE

PAGE = ROOT / "docs/how-to/record.md"


def test_the_commands_of_the_page_record_the_program_of_the_page(tmp_path: Path) -> None:
    write_files(PAGE, tmp_path, "")
    [block] = [b for b in BLOCKS.values() if b.page == PAGE and "talker.py" in b.text[:60]][1:]
    out = ""
    for command in block.text.splitlines():
        done = subprocess.run(
            [ROSBASE, *command.split()[1:]],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=50,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        out += done.stdout
    for topic in ("/position", "/parameter_events", "/rosout"):
        assert topic in out
    [table] = tmp_path.rglob("*.csv")
    # A line for each message, and the head.
    assert len(table.read_text().splitlines()) == 52
