"""The control socket of the IMU reader, as a process, on a line that another program writes to."""

import signal

from rosbase.wire.plain import decoder
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


def test_the_samples_of_a_reader_are_echoed_and_counted(port: PluggablePort) -> None:
    """A reader publishes by prepared senders, which it holds."""
    port.plug()
    with RunningRosbase("imu", "-p", f"device_path:={port.path}") as reader:
        reader.waits_for("opened")
        pid = reader.process.pid
        with connected(pid) as echoing, connected(pid) as counting:
            told = echoing.ask("topic.echo", topic="imu/data")
            counting.ask("topic.count", topic="imu/data", every_ns=50_000_000)
            read = decoder(told["type"], told["schema"])
            for _ in range(20):
                port.write(frame() + b"\n")
            for _ in range(20):
                facts, data = echoing.read()
                assert facts["event"]["dropped"] == 0
                assert read(data)["angular_velocity"] == {"x": 0.1, "y": -0.2, "z": 0.3}
            count = 0
            while count < 20:
                count = counting.read()[0]["event"]["n"]
            assert count == 20
        assert reader.end(signal.SIGINT) == 0
