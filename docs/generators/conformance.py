"""What the implementations of this project declare to the conformance kit, read off their tests.

The tests are read, not run: some of them need ROS, or a broker.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

from attrs import fields

from generators.capabilities import table
from rosbase.testing import BackendCapabilities, TransportCapabilities

__all__ = ["TESTS", "tables", "title_of"]

_ROOT = Path(__file__).parents[2]
TESTS = (
    "tests/core/test_local_contract.py",
    "tests/ros2/test_ros2_contract.py",
    "tests/imu_serial/test_serial_contract.py",
    "tests/imu_mqtt/test_mqtt_contract.py",
    "docs/examples/udp/tests/test_contract.py",
)


def tables() -> str:
    """A table for backends, and one for transports."""
    found = {path: dict(_declared(_ROOT / path)) for path in TESTS}
    parts = []
    for kind, title in ((BackendCapabilities, "backend"), (TransportCapabilities, "transport")):
        defaults = {field.name: repr(field.default) for field in fields(kind)}
        rows = [
            [title_of(path), *(_shown(given.get(name, defaults[name])) for name in defaults)]
            for path, declared in found.items()
            for made, given in declared.items()
            if made == kind.__name__
        ]
        parts.append(table([title, *(f"`{name}`" for name in defaults)], rows))
    return "\n".join(parts)


def title_of(path: str) -> str:
    """What is tested there, by the sentence at its top."""
    tree = ast.parse((_ROOT / path).read_text())
    return (ast.get_docstring(tree) or "").split(" keeps ")[0].split(" keep ")[0]


def _declared(path: Path) -> Iterator[tuple[str, dict[str, str]]]:
    """The capabilities that a test gives, as they are written; those not given are the defaults."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            if node.func.id in (BackendCapabilities.__name__, TransportCapabilities.__name__):
                given = {word.arg or "": ast.unparse(word.value) for word in node.keywords}
                yield node.func.id, given
        # A class that declares nothing has the defaults.
        elif isinstance(node, ast.ClassDef) and not _assigns_capabilities(node):
            base = ast.unparse(node.bases[0]) if node.bases else ""
            if base in ("BackendContract", "TransportContract"):
                yield base.replace("Contract", "Capabilities"), {}


def _assigns_capabilities(node: ast.ClassDef) -> bool:
    return any("capabilities =" in ast.unparse(line) for line in node.body)


def _shown(value: str) -> str:
    if value.startswith("Factory") or value in ("False", "()"):
        return "no"
    return "yes" if value == "True" or value.startswith("(") else f"`{value}`"
