"""What the tests of the transport have in common."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from support.serial_rig import SerialRig


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[SerialRig]:
    rig = SerialRig(tmp_path)
    yield rig
    for transport in rig.made:
        transport.close()
    rig.port.unplug()
