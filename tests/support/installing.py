"""Where install commands are tried: an environment, a copy of the repository, and an index."""

import os
import shlex
import shutil
import subprocess
import sys
import threading
import venv
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from support.code_blocks import ROOT

__all__ = ["OURS", "Environment", "build_wheels", "copy_repository", "serving"]

OURS = {folder.name for folder in (ROOT / "packages").iterdir()}
"""The names of our distributions."""

UV = [sys.executable, "-m", "uv", "pip"]


class Environment:
    """A new virtual environment without anything in it."""

    def __init__(self, folder: Path) -> None:
        venv.create(folder, with_pip=False, symlinks=True)
        self.folder = folder

    def run(self, command: str, clone: Path, index: str = "", *, with_pip: bool = False) -> None:
        """Run a command of pip or copier as it is written, at the top of a clone.

        Args:
            command: The command.
            clone: The clone.
            index: The address of an index beside the usual one.
            with_pip: Whether pip runs its commands, and not uv, which takes the same arguments
                and a fifth of the time.
        """
        program, *arguments = shlex.split(command)
        words = [str(self.folder / "bin" / program), *arguments]
        if program == "pip" and with_pip:
            words = [sys.executable, "-m", "pip", "-q", "--python", str(self.folder), *arguments]
        elif program == "pip":
            action, *rest = arguments
            words = [*UV, action, "-q", "--python", str(self.folder), *rest]
        if index:
            words += ["--extra-index-url", index]
        # No proxy stands before this machine.
        env = {**os.environ, "NO_PROXY": "127.0.0.1", "no_proxy": "127.0.0.1"}
        done = subprocess.run(
            words, cwd=clone, env=env, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, f"{command}\n{done.stderr[-3000:]}"

    def distributions(self) -> set[str]:
        """Return the names of those of our distributions that are installed."""
        found = self.folder.glob("lib/python*/site-packages/*.dist-info")
        return OURS & {path.name.partition("-")[0].replace("_", "-") for path in found}


def copy_repository(folder: Path) -> Path:
    """Copy what commands use of the repository, and return the folder."""
    for part in ("packages", "docs/examples", "docs/template"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / part, folder / part, ignore=ignored)
    return folder


def build_wheels(folder: Path) -> Path:
    """Build our wheels, each in a folder of its name, as an index has them (PEP 503)."""
    for name in sorted(OURS):
        build = [
            sys.executable,
            "-m",
            "hatchling",
            "build",
            "-t",
            "wheel",
            "-d",
            str(folder / name),
        ]
        subprocess.run(build, cwd=ROOT / "packages" / name, check=True, capture_output=True)
    return folder


@contextmanager
def serving(folder: Path) -> Iterator[str]:
    """Serve a folder on loopback; gives the address."""
    handler = partial(_QuietHandler, directory=str(folder))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}/"
        finally:
            server.shutdown()
            thread.join()


class _QuietHandler(SimpleHTTPRequestHandler):
    """Lists folders and serves files, and logs nothing."""

    def log_message(self, format: str, *args: object) -> None: ...  # noqa: A002 - as in the base
