"""What the tests of the transport have in common."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from imu_serial import holders
from support.serial_rig import SerialRig


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[SerialRig]:
    rig = SerialRig(tmp_path)
    yield rig
    for transport in rig.made:
        transport.close()
    rig.port.unplug()


@pytest.fixture(autouse=True)
def no_programs_of_other_tests(monkeypatch: pytest.MonkeyPatch) -> None:
    """Hides the ModemManagers and brlttys that tests start beside this one."""

    def own_children() -> Iterator[int]:
        for listed in Path("/proc/self/task").glob("*/children"):
            yield from map(int, listed.read_text().split())

    monkeypatch.setattr(holders, "_others", own_children)
