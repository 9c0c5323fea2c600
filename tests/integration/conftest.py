"""What the tests of the command have in common."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from support.serial_port import PluggablePort


@pytest.fixture
def port(tmp_path: Path) -> Iterator[PluggablePort]:
    port = PluggablePort(tmp_path)
    yield port
    port.unplug()
