"""Compare a description with this machine: folders, programs, conda environments, CPUs."""

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from rosbase.control.programs import CONTROL_VARIABLE
from rosbase.errors import ConfigurationError
from rosbase.launcher.description import Description, Faults, Program, Session
from rosbase.launcher.description.outside import at_home
from rosbase.launcher.first_words import Word, first_words
from rosbase.launcher.readiness import ASKED
from rosbase.launcher.shell import preparation, shell_path, with_our_python
from rosbase.program.files import read_file
from rosbase.runtime.signal_masks import background_thread
from rosbase.text.printable import one_line, printable

__all__ = ["check_machine", "environment_for"]

_PROBE_S = 60.0
_GRAMMAR = re.compile(r"\b(?:shopt|alias)\b")
_FOUND, _READY = "found", "ready"
_OFF = ("off", "0", "false")


def environment_for(program: Program, environ: Mapping[str, str]) -> dict[str, str]:
    """Return the environment in which the shell of a program begins."""
    path = with_our_python(environ.get("PATH", os.defpath), sys.executable)
    return {**environ, "PATH": path, **program.environment}


def check_machine(description: Description, faults: Faults) -> None:
    """Note what the description needs, and this machine does not have."""
    for session in description.sessions:
        _check_session(session, faults)
    _check_sockets(description, faults)
    absent = _absent({cpu for program in description.programs for cpu in program.cpus})
    for program in description.programs:
        missing = [str(cpu) for cpu in program.cpus if cpu in absent]
        if missing:
            shown = ", ".join(missing[:10]) + (", ..." if len(missing) > 10 else "")
            has = f"this machine has {os.cpu_count()}"
            faults.add(program.lines.get("cpus", 0), f"no CPU {shown} for '{program.key}': {has}")


def _check_sockets(description: Description, faults: Faults) -> None:
    """Note programs that are to be asked whether they are ready, and cannot be."""
    programs = {program.key: program for program in description.programs}
    for program in programs.values():
        for key, condition in program.after.items():
            environment = {**os.environ, **programs[key].environment}
            is_off = environment.get(CONTROL_VARIABLE, "").lower() in _OFF
            if condition.kind in ASKED and is_off:
                text = f"after: {CONTROL_VARIABLE} is off for '{key}', so it tells no {condition}"
                faults.add(program.lines.get("after", 0), text)


def _check_session(session: Session, faults: Faults) -> None:
    setup = session.ros_setup
    if not session.workspace.is_dir():
        text = f"workspace_root: no folder {printable(str(session.workspace))}"
        faults.add(session.lines.get("workspace_root", 0), text)
    if setup is not None and not setup.is_file():
        text = f"ros_setup: no file {printable(str(setup))}"
        faults.add(session.lines.get("ros_setup", 0), text)
        setup = None
    wanted: list[Word] = []
    for program in session.programs:
        if session.workspace.is_dir() and not program.folder.is_dir():
            text = f"project: no folder {printable(str(program.folder))}"
            faults.add(program.lines.get("project", program.lines.get("", 0)), text)
        for file in program.parameter_files:
            if problem := _problem_of_parameters(file):
                faults.add(program.lines.get("parameters", 0), f"parameters: {problem}")
        if problem := _problem_of_grammar(program):
            faults.add(program.lines.get("command", 0), f"command of '{program.key}': {problem}")
        wanted += first_words(program)
    # One shell for all programs that are looked for in the same places.
    by_path: dict[str, list[Word]] = {}
    for word in wanted:
        by_path.setdefault(word.program.environment.get("PATH", ""), []).append(word)
    if session.conda_env and not by_path:
        by_path[""] = []
    for words in by_path.values():
        _probe(session, setup, words, faults)


def _problem_of_parameters(file: Path) -> str:
    """Return why a parameter file cannot be used; empty if it can."""
    if not file.is_file():
        return f"no file {printable(str(file))}"
    try:
        read_file(file)
    except ConfigurationError as error:
        return str(error)
    return ""


def _problem_of_grammar(program: Program) -> str:
    """Return what the shell does not understand in the commands; empty if it may run them."""
    text = "\n".join(program.commands)
    # They change the grammar, as far as they are executed.
    if not text or _GRAMMAR.search(text):
        return ""
    try:
        done = subprocess.run(
            [shell_path(os.environ), "-n", "-c", text],
            check=False,
            capture_output=True,
            stdin=subprocess.DEVNULL,
            timeout=_PROBE_S,
        )
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return ""
    said = done.stderr.decode(errors="replace").splitlines() if done.returncode else []
    # `bash: -c: line 2: syntax error ...`
    return one_line(said[0].rpartition(": line ")[2].partition(": ")[2]) if said else ""


def _probe(session: Session, setup: Path | None, words: list[Word], faults: Faults) -> None:
    """Look for the programs in a shell that is prepared as theirs, and note the missing ones."""
    paths = [word for word in words if "/" in word.text]
    for word in paths:
        path = word.program.folder / _as_bash(word.text)
        if word.program.folder.is_dir() and (problem := _problem_of(path, word)):
            faults.add(word.line, f"command of '{word.program.key}': {problem}")
    names = sorted({word.text for word in words if "/" not in word.text})
    if not (names or session.conda_env):
        return
    answer, problem = _ask_shell(session, setup, names, words)
    if answer is None:
        faults.add(session.lines.get("conda_env" if session.conda_env else "ros_setup", 0), problem)
        return
    for word in words:
        if "/" not in word.text and word.text not in answer:
            text = f"command of '{word.program.key}': there is no program {printable(word.text)}"
            faults.add(word.line, text)


def _problem_of(path: Path, word: Word) -> str:
    """Return why a file cannot be run; empty if it can."""
    shown = printable(word.text)
    if not path.exists():
        return f"no file {shown}"
    if path.is_dir():
        return f"{shown} is a folder"
    return "" if word.is_script or os.access(path, os.X_OK) else f"{shown} is not executable"


def _as_bash(text: str) -> Path:
    """Return the path of a word; bash leaves the `~` of an unknown user as it is."""
    try:
        return at_home(text)
    except ConfigurationError:
        return Path(text)


def _ask_shell(
    session: Session, setup: Path | None, names: list[str], words: list[Word]
) -> tuple[set[str] | None, str]:
    """Return the names that are programs; None, and the reason, if the shell cannot be prepared."""
    environment = dict(os.environ)
    if words:
        environment = environment_for(words[0].program, os.environ)
    text = "\n".join(
        (
            *("exec 3>&1 >/dev/null", preparation(setup, session.conda_env), f"echo {_READY} >&3"),
            # Not as arguments, because a script that is sourced would see them.
            f"for name in {shlex.join(names)}; do",
            f'  command -v -- "$name" >/dev/null 2>&1 && echo "{_FOUND} $name" >&3',
            "done; exit 0",
        )
    )
    conda = f"conda_env: cannot activate '{printable(session.conda_env)}'"
    what = conda if session.conda_env else "ros_setup: cannot be sourced"
    try:
        done = subprocess.run(
            [shell_path(environment), "-c", text],
            check=False,
            capture_output=True,
            stdin=subprocess.DEVNULL,
            env=environment,
            cwd=session.workspace if session.workspace.is_dir() else None,
            timeout=_PROBE_S,
        )
    except subprocess.TimeoutExpired:
        return None, f"{what}: it takes longer than {_PROBE_S:.0f} s"
    except (OSError, ValueError) as error:
        # Such as an environment that is too large.
        return None, f"the shell for the programs cannot start: {one_line(str(error))}"
    lines = done.stdout.decode(errors="replace").splitlines()
    if _READY not in lines:
        said = [line for line in done.stderr.decode(errors="replace").splitlines() if line.strip()]
        return None, f"{what}: {one_line(said[-1] if said else 'it ends the shell')}"
    prefix = f"{_FOUND} "
    return {line.removeprefix(prefix) for line in lines if line.startswith(prefix)}, ""


def _absent(cpus: set[int]) -> set[int]:
    """Return the CPUs on which no thread of this process may run: a thread tries each."""
    absent: set[int] = set()

    def attempt() -> None:
        for cpu in cpus:
            try:
                os.sched_setaffinity(0, {cpu})
            except (OSError, OverflowError, ValueError):
                absent.add(cpu)

    if cpus:
        thread = background_thread(attempt, "CPU")
        thread.start()
        thread.join()
    return absent
