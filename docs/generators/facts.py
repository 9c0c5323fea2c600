"""Version, licence, platform and repository, as the package and the clone have them."""

import re
import subprocess
from pathlib import Path

from rosbase.text.toml import parse_toml

__all__ = ["facts", "repository", "web_address"]

ROOT = Path(__file__).parents[2]
CORE = ROOT / "packages/rosbase-core/pyproject.toml"
# git@host:owner/name.git, and the same as an address; a name and a password are nobody's business.
_REMOTE = re.compile(
    r"(?:https?://(?:[^@/]*@)?|ssh://(?:[^@/]*@)?|[\w.-]+@)"
    r"(?P<host>[\w.-]+)(?::\d+(?=/))?[:/](?P<path>[\w.~/-]+?)(?:\.git)?/?"
)


def facts() -> str:
    """Return a line of Markdown: version, licence, platform, repository if there is an address."""
    project = parse_toml(CORE.read_text())["project"]
    python = project["requires-python"].removeprefix(">=")
    line = f"Version {project['version']} · {project['license']} · Linux · Python {python} or newer"
    address = repository()
    return f"{line} · [Repository]({address})" if address else line


def repository() -> str:
    """Return the web address that this clone comes from, or an empty text."""
    command = ["git", "config", "--get", "remote.origin.url"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return web_address(done.stdout.strip())


def web_address(remote: str) -> str:
    """Return the web address of a remote of git, or an empty text if it is not on a host."""
    found = _REMOTE.fullmatch(remote)
    return f"https://{found['host']}/{found['path']}" if found else ""
