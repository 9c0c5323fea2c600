"""A promise that is broken is shown as what it is, without the code that found out."""

import subprocess
import sys
from pathlib import Path

TEST = """
from rosbase.testing import Promise

def test_it():
    Promise("stop-is-bounded", "stop returns", "plugins/transport").require(False, "it took 9 s")
"""


UNFINISHED = """
from rosbase.local import LocalBackend
from rosbase.testing import BackendContract

class Unfinished(LocalBackend):
    def create_subscription(self, *args):
        raise NotImplementedError("subscribe here")

class TestUnfinished(BackendContract):
    def make_backend(self, options):
        return Unfinished(options)
"""


def failures_of(test: str, folder: Path, *arguments: str) -> str:
    (folder / "test_it.py").write_text(test)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *arguments]
    shown = subprocess.run(command, check=False, capture_output=True, text=True, cwd=folder)
    assert shown.returncode == 1
    return shown.stdout


def test_an_error_that_no_check_expects_breaks_its_promise_and_keeps_its_traceback(
    tmp_path: Path,
) -> None:
    shown = failures_of(UNFINISHED, tmp_path, "-k", "keep_all_drops_none")
    assert "broken promise: keep-all-drops-none\n" in shown
    assert "a call raised NotImplementedError('subscribe here'), in test_it.py:7\n" in shown
    assert "docs/plugins/backend-contract.md#keep-all-drops-none" in shown
    assert "def create_subscription" in shown


def test_pytest_shows_a_broken_promise_as_four_lines(tmp_path: Path) -> None:
    shown = failures_of(TEST, tmp_path)
    assert (
        "broken promise: stop-is-bounded\n"
        "  promised: stop returns\n"
        "  seen:     it took 9 s\n"
        "  more:     docs/plugins/transport.md#stop-is-bounded\n"
    ) in shown
    assert "def require" not in shown


WITHOUT_TOOLS = """
import sys
sys.modules["pytest"] = sys.modules["hypothesis"] = None
import rosbase.testing
for name in rosbase.testing.__all__:
    if not name.endswith("Contract") and name not in ("BackendCapabilities", "ServiceKind"):
        getattr(rosbase.testing, name)
"""


def test_all_but_the_contracts_is_there_without_pytest_and_hypothesis() -> None:
    subprocess.run([sys.executable, "-c", WITHOUT_TOOLS], check=True)
