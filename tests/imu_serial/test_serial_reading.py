"""What comes over the line is handed over as it should be, a lot of it."""

from support.serial_rig import SerialRig


def test_lines_come_through_whole_and_in_order(rig: SerialRig) -> None:
    transport = rig.started()
    rig.port.write(b"".join(b"%d\r\n" % number for number in range(5000)))
    assert [int(rig.next()) for _ in range(5000)] == list(range(5000))
    assert transport.health.frame_errors == {}
