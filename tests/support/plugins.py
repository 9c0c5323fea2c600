"""Installed packages that exist for one test: metadata and a module in a folder."""

from pathlib import Path

from rosbase.plugins.discovery import Candidate, find_candidates


def install_plugin(folder: Path, distribution: str, name: str, code: str | None) -> None:
    """Puts a distribution with one `rosbase` entry point into the folder.

    Args:
        folder: Stands for site-packages.
        distribution: The name of the distribution.
        name: The name of the entry point.
        code: The source of its module; None for metadata without a module.
    """
    module = f"{distribution}_{name}".replace("-", "_")
    info = folder / f"{distribution.replace('-', '_')}-1.2.dist-info"
    info.mkdir(exist_ok=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1.2\n")
    (info / "entry_points.txt").write_text(f"[rosbase]\n{name} = {module}\n")
    if code is not None:
        (folder / f"{module}.py").write_text(code)


def candidates_in(folder: Path) -> list[Candidate]:
    """What was installed there."""
    return find_candidates("rosbase", [str(folder)])


TRANSPORT_PLUGIN = """
from rosbase.plugins import TransportPlugin, hookimpl

def create(values, context):
    raise NotImplementedError

@hookimpl
def rosbase_transports():
    yield TransportPlugin("{name}", "a test", create)
"""

CONVERSION_PLUGIN = """
import attrs
from rosbase.messages import Vector3
from rosbase.plugins import ConversionPlugin, hookimpl

@attrs.frozen
class Force:
    force: Vector3
    torque: Vector3

def create():
    {create}

@hookimpl
def rosbase_conversions():
    yield ConversionPlugin({msg_type}, "ros2", "geometry_msgs/Wrench", create)
"""

BROKEN_PLUGINS: dict[str, tuple[str | None, str]] = {
    "unimportable": ("import no_such_library", "ModuleNotFoundError: No module named 'no_such"),
    "vanished": (None, "ModuleNotFoundError"),
    "syntax": ("def (", "SyntaxError"),
    "exits": ("raise SystemExit(3)", "SystemExit: 3"),
    "misspelt": (
        "from rosbase.plugins import hookimpl\n@hookimpl\ndef rosbase_transport(): return ()",
        "unknown hook 'rosbase_transport'",
    ),
    "unmarked": ("def rosbase_transports(): return ()", "not marked with @hookimpl"),
    "arguments": (
        "from rosbase.plugins import hookimpl\n@hookimpl\ndef rosbase_transports(x): return ()",
        "PluginValidationError",
    ),
    "raising": (
        "from rosbase.plugins import hookimpl\n@hookimpl\ndef rosbase_transports(): 1 / 0",
        "ZeroDivisionError",
    ),
    "raising_late": (
        "from rosbase.plugins import hookimpl\n@hookimpl\n"
        "def rosbase_transports():\n    yield from ()\n    raise OSError('no\\nluck')",
        "OSError: no luck",
    ),
    "wrong_type": (
        "from rosbase.plugins import hookimpl\n@hookimpl\ndef rosbase_transports(): yield 'udp'",
        "rosbase_transports must yield TransportPlugin, not str",
    ),
    "not_iterable": (
        "from rosbase.plugins import hookimpl\n@hookimpl\ndef rosbase_transports(): return 5",
        "TypeError",
    ),
    "gives_none": (
        "from rosbase.plugins import hookimpl\n@hookimpl\ndef rosbase_transports(): pass",
        "rosbase_transports gave None: does it yield or return what it brings?",
    ),
    "base_exception": ("raise BaseException('odd')", "BaseException: odd"),
    "parameters": (
        TRANSPORT_PLUGIN.format(name="x").replace("create)", "create, parameters=None)"),
        "'parameters' must be",
    ),
    "no_summary": (TRANSPORT_PLUGIN.format(name="x").replace('"a test"', "None"), "'summary' must"),
    "not_callable": (TRANSPORT_PLUGIN.format(name="x").replace("create)", "5)"), "'create' must"),
    "no_class": (
        CONVERSION_PLUGIN.format(create="pass", msg_type="'Force'"),
        "'msg_type' must be",
    ),
    "known_class": (
        CONVERSION_PLUGIN.format(create="pass", msg_type="Vector3"),
        "Vector3 is a message of rosbase, which every backend knows",
    ),
    "bad_name": (TRANSPORT_PLUGIN.format(name="two words"), "name must be one word"),
}
"""By what is wrong: the source of the plugin, and what the reason must say."""
