"""What every test must leave as it found it: threads, descriptors, child processes."""

import logging
import os
import signal
import tempfile
import threading
from collections.abc import Generator, Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from rosbase.control.recent_log import recent_log
from rosbase.logger import use_console
from rosbase.logger.log_file import use_log_file

# Machines that run tests are busy; the time limit of the test run is the one that counts.
settings.register_profile("rosbase", deadline=None)
settings.load_profile("rosbase")

# Whoever runs us in the background, as with nohup, has us ignore signals, and every process that
# a test starts would too.
for _signum in (signal.SIGHUP, signal.SIGINT):
    if signal.getsignal(_signum) is signal.SIG_IGN:
        signal.signal(_signum, signal.SIG_DFL)

# ROS reads it when a class of messages is imported, which is before any fixture.
os.environ["ROS_PYTHON_CHECK_FIELDS"] = "1"

_STRANGE = ("NO_COLOR", "PYTHONDONTWRITEBYTECODE", "PYTHONUNBUFFERED")
_FDS = Path("/proc/self/fd")
_CHILDREN = Path("/proc/self/task")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Writes out what a test has logged that is no text: pytest-xdist cannot send it."""
    report = yield
    report.sections = [
        (name, text.encode(errors="backslashreplace").decode()) for name, text in report.sections
    ]
    return report


@pytest.fixture(autouse=True)
def nothing_leaks() -> Iterator[None]:
    """Fails a test that leaves a thread, a descriptor or a child process behind."""
    threads, fds = set(threading.enumerate()), _open_descriptors()
    yield
    for thread in set(threading.enumerate()) - threads:
        thread.join(2.0)
        assert not thread.is_alive(), f"leaked thread {thread.name}"
    leaked = {fd: name for fd, name in _open_descriptors().items() if fds.get(fd) != name}
    assert not leaked, f"leaked descriptors: {leaked}"
    assert not _children(), f"leaked child processes: {_children()}"


@pytest.fixture(scope="session")
def runtime_dir() -> Iterator[str]:
    """A folder for the control sockets of all tests, apart from the user's programs."""
    # Not in a folder of pytest's: the path of a socket is short.
    with tempfile.TemporaryDirectory(prefix="rosbase-tests-") as folder:
        yield folder


@pytest.fixture(autouse=True)
def own_surroundings(monkeypatch: pytest.MonkeyPatch, runtime_dir: str) -> Iterator[None]:
    """Keeps the user's environment and the last test's logging out of a test."""
    # PYTHONUNBUFFERED too: a new user has it not set, and output behaves differently with it.
    # Commands that may not write bytecode take twice as long to start.
    for name in [n for n in os.environ if n.startswith(("ROSBASE_", "RCUTILS_")) or n in _STRANGE]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("XDG_RUNTIME_DIR", runtime_dir)
    use_console(None)
    recent_log.stop()
    logger = logging.getLogger("rosbase")
    before = logger.handlers[:], logger.level, logger.propagate
    yield
    logger.handlers[:], logger.level, logger.propagate = before
    use_log_file(None)


def _open_descriptors() -> dict[str, str]:
    """Where each descriptor leads to; none where the system does not tell."""
    found = {}
    for link in _FDS.iterdir() if _FDS.exists() else ():
        try:
            found[link.name] = os.readlink(link)
        except OSError:
            # The descriptor of this very listing.
            continue
    return found


def _children() -> list[str]:
    found = []
    for listed in _CHILDREN.glob("*/children") if _CHILDREN.exists() else ():
        try:
            found += listed.read_text().split()
        except OSError:
            # The thread has ended meanwhile.
            continue
    return found
