"""The page about the log shows what is logged."""

import re
import subprocess
import sys

from support.code_blocks import ROOT
from support.log_lines import without_times

PAGE = (ROOT / "docs/logging.md").read_text()


def test_the_first_program_logs_what_stands_below_it() -> None:
    program, shown = re.findall(r"```(?:python|text)\n(.*?)```", PAGE, re.S)[:2]
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=30, check=True
    )
    assert without_times(done.stderr) == without_times(shown)
    assert done.stderr != without_times(done.stderr)
