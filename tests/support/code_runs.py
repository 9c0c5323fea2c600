"""Runs the blocks of the documentation, as a reader would."""

import os
import re
import shlex
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from imu_serial.simulator import PtyDevice
from rosbase.errors import TransportError
from support.code_blocks import DEVICE, ROOT, Block, write_files
from support.command import RunningRosbase
from support.samples import GOOD_FRAME
from support.waiting import wait_until

BIN = Path(sys.executable).parent
# As in pyproject.toml: lark, which rclpy imports, uses it.
WARNINGS = ("-W", "error", "-W", "ignore:module 'sre_:DeprecationWarning")
SKIPPED = ("pip install", "nox")
"""What is installed is installed already, and a test must not run all tests."""

SEEN = re.compile(r"published [1-9]|^\{")
"""A status line, or a sample as JSON."""


def run_python(block: Block, folder: Path) -> None:
    """Runs a program, or the tests in it; it must say something, and complain of nothing."""
    write_files(block.page, folder, DEVICE)
    program = folder / (block.file or "test_shown.py")
    program.write_text(block.text)
    pytest = ["-m", "pytest", "-q", "-p", "no:cacheprovider"]
    options = pytest if re.search(r"^(def test_|class Test)", block.text, re.M) else []
    done = subprocess.run(
        [sys.executable, *WARNINGS, *options, program.name],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=50,
        check=False,
    )
    expected = ("[INFO] ", "[ERROR] ") if "logs errors" in block.says else ("[INFO] ",)
    complaints = [line for line in done.stderr.splitlines() if not line.startswith(expected)]
    assert (done.returncode, complaints) == (0, []), done.stdout
    # What is only imported by another file of the page says nothing.
    assert done.stdout or block.file
    if block.prints is not None:
        assert done.stdout == block.prints


def run_commands(block: Block, folder: Path) -> None:
    """Runs each command at the top of the repository, or with a device in a folder of its own."""
    lines = block.text.replace("\\\n", "").splitlines()
    commands = [part.strip() for line in lines for part in line.split("&&")]
    for command in commands:
        if command.startswith(SKIPPED) or not command:
            continue
        if block.device is None:
            _run(command, ROOT, block.status)
        else:
            with sending(block.device) as path:
                write_files(block.page, folder, path)
                _run_reader(command.replace(DEVICE, path), folder, block.status)


@contextmanager
def sending(line: str) -> Iterator[str]:
    """A simulated device that sends a line, or a sample, a hundred times a second; its path."""
    device, stop = PtyDevice(), threading.Event()
    payload = line.encode() or GOOD_FRAME

    def send() -> None:
        while not stop.wait(0.01):
            # On a line that is full because nobody reads any more, it waits for the end.
            with suppress(TransportError):
                device.send(payload)

    thread = threading.Thread(target=send)
    thread.start()
    try:
        yield str(device.parameters["device_path"])
    finally:
        stop.set()
        device.close()
        thread.join()


def _run(command: str, folder: Path, status: int) -> None:
    done = subprocess.run(
        command,
        shell=True,
        cwd=folder,
        env={**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        timeout=50,
        check=False,
    )
    assert done.returncode == status, done.stderr


def _run_reader(command: str, folder: Path, status: int) -> None:
    """Runs a reader until a sample is there, unless the command ends by itself."""
    if "|" in command or "--duration" in command:
        _run(command, folder, status)
        return
    program, *arguments = shlex.split(command)
    assert program == "rosbase", command
    files = {path.name: str(path) for path in folder.iterdir()}
    with RunningRosbase(*(files.get(word, word) for word in arguments)) as reader:
        wait_until(lambda: any(map(SEEN.search, reader.out.lines)), f"a sample from {command}")
        assert reader.end(signal.SIGINT) == 0, reader.err.lines
