"""The example of a third party's plugin, installed: `rosbase imu` reads from it."""

import socket
import subprocess
import sys

from rosbase.imu.simulator import payload_at
from rosbase.messages import Time
from support.command import Lines
from support.waiting import wait_until


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def test_rosbase_imu_reads_datagrams() -> None:
    port = free_port()
    command = [sys.executable, "-u", "-W", "error", "-m", "rosbase", "imu", "--topic-echo"]
    parameters = ["-p", "comm_t:=udp", "-p", f"udp_address:=127.0.0.1:{port}"]
    with (
        subprocess.Popen([*command, *parameters], stdout=subprocess.PIPE, text=True) as process,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as device,
    ):
        assert process.stdout is not None
        out = Lines(process.stdout)

        def echoes() -> bool:
            # What comes before the reader is active is discarded.
            device.sendto(payload_at(0.5, Time(1, 2)), ("127.0.0.1", port))
            return any("linear_acceleration" in line for line in out.lines)

        try:
            wait_until(echoes, "a sample")
            process.terminate()
            assert process.wait(20) == 0
        finally:
            process.kill()
            out.join()
