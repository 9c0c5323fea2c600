"""A promise that is broken is shown as what it is, without the code that found out."""

import subprocess
import sys
from pathlib import Path

TEST = """
from rosbase.testing import Promise

def test_it():
    Promise("stop-is-bounded", "stop returns", "plugins/transport").require(False, "it took 9 s")
"""


def test_pytest_shows_a_broken_promise_as_four_lines(tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text(TEST)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)]
    shown = subprocess.run(command, check=False, capture_output=True, text=True, cwd=tmp_path)
    assert shown.returncode == 1
    assert (
        "broken promise: stop-is-bounded\n"
        "  promised: stop returns\n"
        "  seen:     it took 9 s\n"
        "  more:     docs/plugins/transport.md#stop-is-bounded\n"
    ) in shown.stdout
    assert "def require" not in shown.stdout


WITHOUT_TOOLS = """
import sys
sys.modules["pytest"] = sys.modules["hypothesis"] = None
import rosbase.testing
for name in rosbase.testing.__all__:
    if not name.endswith("Contract") and name != "BackendCapabilities":
        getattr(rosbase.testing, name)
"""


def test_all_but_the_contracts_is_there_without_pytest_and_hypothesis() -> None:
    subprocess.run([sys.executable, "-c", WITHOUT_TOOLS], check=True)
