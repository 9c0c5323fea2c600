"""`rosbase doctor`: check everything that a run needs, and give advice on each problem."""

import argparse
import json
import sys
from contextlib import nullcontext, redirect_stdout
from typing import Any

from rosbase.cli.arguments import add_parameters, check_given, read_given
from rosbase.cli.examination import examine
from rosbase.clock import SystemClock
from rosbase.contracts.checks import CheckContext, Finding, Outcome
from rosbase.imu.settings import reader_parameters
from rosbase.plugins import PluginRegistry, installed_plugins

__all__ = ["configure", "run"]

# All checks together; starting ROS on a busy machine takes the longest.
_LIMIT_S = 15.0


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_parameters(parser)
    parser.add_argument(
        "--json", action="store_true", help="print one object of JSON instead of lines"
    )


def run(arguments: argparse.Namespace) -> int:
    """Print the findings; return 0 if nothing failed."""
    registry = installed_plugins()
    context, found = _context(registry, arguments), []
    # What a check prints must not stand within the object.
    with redirect_stdout(sys.stderr) if arguments.json else nullcontext():
        for check, finding in examine(registry, context, _LIMIT_S):
            found.append((check, finding))
            if not arguments.json:
                _show(check, finding)
    has_failed = any(finding.outcome is Outcome.FAIL for _, finding in found)
    if arguments.json:
        findings = [_as_data(check, finding) for check, finding in found]
        print(json.dumps({"ok": not has_failed, "findings": findings}, indent=2))
    return int(has_failed)


def _context(registry: PluginRegistry, arguments: argparse.Namespace) -> CheckContext:
    given = read_given(arguments.assignments, arguments.params_file)
    if "comm_t" in given:
        # First, because a transport that is not installed leaves its parameters unknown.
        registry.transport(given["comm_t"].text)
    specs = reader_parameters(registry)
    values = {spec.name: spec.default for spec in specs} | check_given(specs, given)
    return CheckContext(SystemClock(), values, frozenset(given))


def _show(check: str, finding: Finding) -> None:
    lines = [f"{finding.outcome.value:4}  {check}: {finding.text}"]
    if finding.advice:
        lines.append(f"      {finding.advice}")
    encoding = sys.stdout.encoding or "utf-8"
    for line in lines:
        # A name of a device may have letters that the terminal has not.
        print(line.encode(encoding, "backslashreplace").decode(encoding), flush=True)


def _as_data(check: str, finding: Finding) -> dict[str, Any]:
    return {
        "check": check,
        "outcome": finding.outcome.value,
        "text": finding.text,
        "advice": finding.advice,
    }
