"""The shell script of a program: prepare the environment, change the folder, run the commands."""

import os
import re
import shlex
from collections.abc import Iterable, Mapping
from pathlib import Path

from rosbase.launcher.description import Program, Session

__all__ = ["preparation", "script", "shell_path", "with_our_python"]

# `conda activate` is a function that conda's hook defines; a shell of ours has none yet. The places
# are the ones that its installers propose.
_CONDA = """\
if ! type conda 2>/dev/null | grep -q function; then
  for rosbase_conda in "${CONDA_EXE:-}" "$(command -v conda)" ~/miniconda3/bin/conda \
      ~/miniforge3/bin/conda ~/anaconda3/bin/conda ~/mambaforge/bin/conda /opt/conda/bin/conda
  do
    [ -x "$rosbase_conda" ] && break
  done
  if [ ! -x "$rosbase_conda" ]; then
    echo "conda is not on PATH, and not where its installers put it" >&2
    exit 1
  fi
  eval "$("$rosbase_conda" shell.posix hook)" || exit 1
fi
conda activate %s || exit 1"""
# More than one program, its arguments and variables: then the shell stays.
_NOT_SIMPLE = re.compile(r"[;&|<>(){}\n`#]")
_PROGRAM = re.compile(r"[\w./~+-]+", re.ASCII)
# A list of commands must not go on when the running one has been asked to stop.
_END = "trap 'exit $?' INT TERM HUP"


def shell_path(environ: Mapping[str, str]) -> str:
    """Return the shell for programs: bash, in which most users type, or else /bin/sh."""
    for folder in environ.get("PATH", os.defpath).split(os.pathsep):
        bash = os.path.join(folder, "bash")
        if os.path.isabs(bash) and os.access(bash, os.X_OK):
            return bash
    return "/bin/sh"


def preparation(ros_setup: Path | None, conda_env: str) -> str:
    """Return the lines that source the setup of ROS, and then activate the conda environment."""
    lines = []
    if ros_setup is not None:
        # Its status says nothing: many a setup ends with a test that fails.
        lines.append(f". {shlex.quote(str(ros_setup))}")
    if conda_env:
        lines.append(_CONDA % shlex.quote(conda_env))
    return "\n".join(lines)


def script(session: Session, program: Program) -> str:
    """Return the script that runs a program and ends with the status of its last command."""
    prepared = preparation(session.ros_setup, session.conda_env)
    lines: Iterable[str] = [
        # As the check does, and wherever the shell begins: in the folder of the user, or of a pane.
        f"cd {shlex.quote(str(session.workspace))} || exit 1" if prepared else "",
        prepared,
        f"cd {shlex.quote(str(program.folder))} || exit 1",
        _END if len(program.commands) > 1 else "",
        *program.commands[:-1],
        *map(_last, program.commands[-1:]),
    ]
    return "\n".join(line for line in lines if line)


def _last(command: str) -> str:
    """Return the last command so that the shell becomes its program, if it is a plain one.

    Signals then reach the program itself. Builtins, functions and aliases need the shell.
    """
    word = (command.split() or [""])[0]
    if _NOT_SIMPLE.search(command) or not _PROGRAM.fullmatch(word):
        return command
    return f'if [ "$(type -t {word})" = file ]; then exec {command}; fi\n{command}'


def with_our_python(path: str, python: str) -> str:
    """Return a PATH that also has the folder of this Python, behind all others.

    So `rosbase`, and `python` where there is no other, are found without an active environment.
    """
    folder = os.path.dirname(python)
    folders = path.split(os.pathsep) if path else []
    return os.pathsep.join(folders if folder in folders else [*folders, folder])
