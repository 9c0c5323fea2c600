"""The control socket of the IMU reader, as a process, on a line that another program writes to."""

import signal

from support.command import RunningRosbase
from support.control import connected
from support.samples import frame
from support.serial_port import PluggablePort
from support.waiting import wait_until


def test_a_reader_is_looked_at_and_operated_while_it_reads(port: PluggablePort) -> None:
    port.plug()
    with RunningRosbase("imu", "-p", f"device_path:={port.path}") as reader:
        reader.waits_for("opened")
        with connected(reader.process.pid) as client:
            wait_until(
                lambda: client.ask("process")["programs"][0]["phase"] == "running", "the loop"
            )
            (program,) = client.ask("process")["programs"]
            assert program["kind"] == "manager"
            (node,) = client.ask("lifecycle.list")["nodes"]
            name = node["name"]
            assert node["state"] == "active"
            found = client.ask("parameter.get", node=name, names=["device_path", "baudrate"])
            assert found["values"]["device_path"] == {"type": "string", "value": str(port.path)}
            assert found["values"]["baudrate"]["type"] == "integer"
            described = client.ask("parameter.describe", node=name, names=["baudrate"])
            assert described["descriptors"]["baudrate"]["description"]
            found = client.ask("parameter.set", node=name, values={"baudrat": 2})
            (result,) = found["results"].values()
            assert not result["successful"]
            assert client.ask("log", level="info")["count"] > 0
            while "end" not in client.read()[0]:
                pass
            assert client.ask("lifecycle.set", node=name, transition="deactivate")["successful"]
            assert client.ask("lifecycle.set", node=name, transition="activate")["successful"]
            port.write(frame() + b"\n")
            assert client.ask("stop")["programs"] == [program["name"]]
            assert client.is_closed()
        assert reader.process.wait(20) == 0


def test_a_signal_ends_a_reader_that_somebody_follows(port: PluggablePort) -> None:
    port.plug()
    with RunningRosbase("imu", "-p", f"device_path:={port.path}") as reader:
        reader.waits_for("opened")
        with connected(reader.process.pid) as client:
            client.ask("log", follow=True)
            assert reader.end(signal.SIGINT) == 0
            assert client.is_closed()
        assert "control" not in reader.err
