"""The mapping language for devices that are no IMU."""

from typing import Any

import pytest

from rosbase import Batch, PayloadMapping, Quantity, Reject, TimeMapping

GPS = PayloadMapping(
    (
        Quantity("position", ("lat", "lon"), components=("latitude", "longitude"), required=True),
        Quantity("altitude", ("alt",), components=("altitude",), largest=1e5),
        Quantity("speed", ("v",), components=("speed",), factor=1 / 3.6),
    ),
    TimeMapping(("time",), "s"),
    select=("class=TPV",),
)


def test_a_receiver_of_satellites_as_gpsd_prints_it() -> None:
    read = GPS.compile(tuple, device_time=True)
    line = b'{"class":"TPV","time":"2025-10-01T12:00:00Z","lat":48.1,"lon":11.5,"alt":519,"v":36}'
    date_ns = 1_759_320_000_000_000_000
    assert read(line) == ((48.1, 11.5), (519.0,), (10.0,), date_ns, ())
    assert read(b'{"class":"SKY","satellites":[]}') == Reject("not_selected")
    late = read(b'{"class":"TPV","lat":48.1,"lon":11.5,"alt":2e5}')
    assert isinstance(late, tuple)
    assert late[:3] == ((48.1, 11.5), None, None)
    assert [reject.reason for reject in late[4]] == ["out_of_range", "time_unusable"]
    assert read(b'{"class":"TPV","lat":48.1}') == Reject(
        "incomplete", "position lacks lon; mapping.absent:=zero if zeros are left out"
    )


def test_the_cells_of_a_battery_several_times_in_a_message() -> None:
    cells = Quantity("cells", ("log[*].mv",), components=("a", "b", "c", "d", "e"), factor=1e-3)
    read = PayloadMapping((cells,)).compile(tuple)
    found = read(b'{"log":[{"mv":[4100,4100,4090,4110,4100]},{"mv":[4100]}]}')
    assert isinstance(found, Batch)
    first, second = found.samples
    assert isinstance(first, tuple)
    assert first[0] == pytest.approx((4.1, 4.1, 4.09, 4.11, 4.1))
    assert isinstance(second, Reject)
    assert second.reason == "incomplete"


def test_a_payload_of_something_else_has_the_reason_that_is_asked_for() -> None:
    read: Any = PayloadMapping((Quantity("x", ("x",), components=("x",)),)).compile(
        tuple, nothing="no_position"
    )
    assert read(b"{}") == Reject("no_position")
