"""`rosbase imu` as a process, on a real line that another program writes to."""

import io
import itertools
import json
import re
import signal
import sys
import time
from functools import partial
from pathlib import Path

import pytest

from rosbase.cli.console import LogOutput
from rosbase.cli.session import ReaderManager
from support.command import ROSBASE, RunningRosbase, run_rosbase, summary_of
from support.processor_time import least_cpu_s
from support.samples import FAULTS, GOOD_FRAME, ORIENTATION_FAULTS, frame
from support.serial_port import PluggablePort
from support.waiting import wait_until

# Each is dated after the last, for the reader drops repeats.
_seconds = itertools.count(1_700_000_000)


def echoing(port: PluggablePort, *more: str) -> RunningRosbase:
    """A reader on the port that prints what it publishes, once it does."""
    port.plug()
    reader = RunningRosbase("imu", "-p", f"device_path:={port.path}", "--topic-echo", *more)
    reader.waits_for("opened")
    written_s = 0.0

    def is_reading() -> bool:
        nonlocal written_s
        # One at a time: what fills the line before it is read is cut somewhere.
        if time.monotonic() - written_s > 0.1:
            written_s = time.monotonic()
            port.write(frame(header={"stamp": {"sec": next(_seconds), "nanosec": 0}}) + b"\n")
        return bool(reader.out.lines)

    wait_until(is_reading, "the first sample")
    return reader


def says_more(reader: RunningRosbase, part: str, before: dict[str, int]) -> None:
    """Waits until it has said that more often than before."""
    wait_until(lambda: reader.err.count(part) > before[part], f"{part!r} to be said")


def next_sample(reader: RunningRosbase, port: PluggablePort, mark: float) -> None:
    """Sends a sample with a mark in it, and waits for that sample."""
    port.write(frame(angular_velocity={"x": mark, "y": 0.0, "z": 0.0}) + b"\r\n")
    reader.waits_for(f'"angular_velocity":{{"x":{mark},', where=reader.out)


def test_each_bad_line_is_dropped_and_counted_and_the_next_good_line_comes_through(
    port: PluggablePort,
) -> None:
    expected: dict[str, int] = {}
    with echoing(port) as reader:
        for number, (line, reason) in enumerate(FAULTS.values(), start=1):
            expected[reason] = expected.get(reason, 0) + 1
            port.write(line + b"\n")
            next_sample(reader, port, number + 0.5)
        port.write(b"x" * 70_000 + b"\n")
        next_sample(reader, port, -1.5)
        assert reader.end(signal.SIGINT) == 0
    counts = summary_of(reader.err.lines)
    assert {reason: counts[reason] for reason in expected} == expected
    assert counts["overlong"] == 1
    assert counts["published"] == len(reader.out.lines)
    assert counts["received"] == counts["published"] + counts["rejected"] + counts["ignored"]
    assert "Traceback" not in reader.err


def test_a_quantity_that_is_left_out_is_in_the_summary(port: PluggablePort) -> None:
    expected: dict[str, int] = {}
    with echoing(port) as reader:
        for number, (line, reason) in enumerate(ORIENTATION_FAULTS.values(), start=1):
            expected[f"left_out_{reason}"] = expected.get(f"left_out_{reason}", 0) + 1
            port.write(line + b"\n")
            next_sample(reader, port, number + 0.5)
        assert reader.end(signal.SIGINT) == 0
    counts = summary_of(reader.err.lines)
    assert {name: counts[name] for name in expected} == expected
    assert counts["rejected"] == 0
    without = [line for line in reader.out.lines if '"orientation_covariance":[-1.0' in line]
    assert len(without) == len(ORIENTATION_FAULTS)


COLUMNS = """\
preset = "custom"
time_source = "device"
[mapping.linear_acceleration]
paths = ['"acc.x"[*]', '"acc.y"[*]', '-"acc.z"[*]']
unit = "g"
[mapping.time]
paths = ["start"]
unit = "ms"
interval = "rate Hz"
"""


def test_a_message_with_several_samples_is_as_many_lines(
    port: PluggablePort, tmp_path: Path
) -> None:
    file = tmp_path / "columns.toml"
    file.write_text(COLUMNS)
    port.plug()
    with RunningRosbase(
        "imu", "-p", f"device_path:={port.path}", "--params-file", str(file), "--topic-echo"
    ) as reader:
        reader.waits_for("opened")
        start_ms = int(time.time()) * 1_000

        def arrives() -> bool:
            nonlocal start_ms
            start_ms += 1_000
            x, y, z = [0.0, 0.5, 1.0], [0.0] * 3, [-1.0] * 3
            line = {"start": start_ms, "rate": 200, "acc.x": x, "acc.y": y, "acc.z": z}
            port.write(json.dumps(line).encode() + b"\n")
            return len(reader.out.lines) >= 3

        wait_until(arrives, "three samples")
        assert reader.end(signal.SIGINT) == 0
    samples = [json.loads(line) for line in reader.out.lines]
    assert len(samples) % 3 == 0
    first = [sample["linear_acceleration"] for sample in samples[:3]]
    assert [a["x"] for a in first] == [0.0, 0.5 * 9.80665, 9.80665]
    assert {a["z"] for a in first} == {9.80665}
    stamps = [sample["header"]["stamp"]["nanosec"] for sample in samples[:3]]
    assert stamps == [0, 5_000_000, 10_000_000]


def test_each_published_sample_is_one_line_of_json_in_the_default_shape(
    port: PluggablePort,
) -> None:
    with echoing(port) as reader:
        next_sample(reader, port, 0.25)
        reader.end(signal.SIGTERM)
    for line in reader.out.lines:
        sample = json.loads(line)
        assert list(sample) == [
            "header",
            "orientation",
            "orientation_covariance",
            "angular_velocity",
            "angular_velocity_covariance",
            "linear_acceleration",
            "linear_acceleration_covariance",
        ]
        assert sample["linear_acceleration"]["z"] == 9.80665
        assert sample["header"]["frame_id"] == "imu_link"


def test_what_it_prints_can_be_read_by_another_reader(port: PluggablePort, tmp_path: Path) -> None:
    with echoing(port) as first:
        next_sample(first, port, 0.25)
        first.end(signal.SIGTERM)
    (tmp_path / "second").mkdir()
    second_port = PluggablePort(tmp_path / "second")
    with echoing(second_port, "-p", "time_source:=device") as second:
        second_port.write(first.out.lines[-1].encode() + b"\n")
        wait_until(lambda: second.out.lines[-1] == first.out.lines[-1], "the same sample")
        second.end(signal.SIGTERM)
    second_port.unplug()


def test_unplugging_and_replugging_needs_no_action(port: PluggablePort) -> None:
    with echoing(port) as reader:
        for number in range(1, 4):
            before = {part: reader.err.count(part) for part in ("trying again", "is back")}
            port.unplug()
            says_more(reader, "trying again", before)
            port.plug()
            says_more(reader, "is back", before)

            def is_reading(mark: float = number + 0.125) -> bool:
                port.write(frame(angular_velocity={"x": mark, "y": 0.0, "z": 0.0}) + b"\n")
                return f'"x":{mark},' in reader.out

            wait_until(is_reading, "samples after the replug")
        assert reader.end(signal.SIGINT) == 0
    assert summary_of(reader.err.lines)["reconnects"] == 3


ABSENT = {
    "a device": (["device_path:=/dev/nix"], "/dev/nix is not there", "wait_for_device"),
    "a broker": (
        ["transport:=mqtt", "server_address:=tcp://localhost:1"],
        "there is no broker at tcp://localhost:1",
        "wait_for_broker",
    ),
}


@pytest.mark.parametrize(("parameters", "why", "option"), ABSENT.values(), ids=ABSENT)
def test_what_is_absent_ends_it_at_once_with_status_1_and_what_to_do(
    parameters: list[str], why: str, option: str
) -> None:
    given = [word for text in parameters for word in ("-p", text)]
    done = run_rosbase("imu", *given)
    assert (done.returncode, done.stdout) == (1, "")
    reason, advice = done.stderr.splitlines()
    assert why in reason
    assert advice.startswith("rosbase: the reader did not become active. `rosbase doctor`")
    assert f"-p {option}:=true" in advice


def test_a_run_that_published_nothing_in_its_time_has_failed(port: PluggablePort) -> None:
    port.plug()
    done = run_rosbase("imu", "-p", f"device_path:={port.path}", "--duration", "0.5")
    assert done.returncode == 1
    assert summary_of(done.stdout.splitlines())["published"] == 0
    assert done.stderr.splitlines()[-1].startswith("rosbase: nothing was published. `rosbase doc")


def test_a_parameter_in_two_spellings_is_refused() -> None:
    done = run_rosbase("imu", "-p", "transport:=mqtt", "-p", "comm_t:=serial")
    assert (done.returncode, done.stderr) == (
        2,
        "rosbase: transport and comm_t are one parameter: give one of them\n",
    )


def test_an_absent_device_is_waited_for_by_option(port: PluggablePort) -> None:
    with RunningRosbase(
        "imu", "-p", f"device_path:={port.path}", "-p", "wait_for_device:=true", "--topic-echo"
    ) as reader:
        reader.waits_for("is not there")
        port.plug()
        # Opened when the reader starts, or there later on: it depends on who was quicker.
        wait_until(lambda: "opened" in reader.err or "is there" in reader.err, "the good news")

        def is_reading() -> bool:
            port.write(GOOD_FRAME + b"\n")
            return bool(reader.out.lines)

        wait_until(is_reading, "the first sample")
        assert reader.end(signal.SIGINT) == 0
    assert "Traceback" not in reader.err


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["-p", "baudrate:=fast"], "parameter baudrate takes a whole number, not 'fast'"),
        (["-p", "baudrate:=0"], "parameter baudrate is at least 1, not 0"),
        (["-p", "device:=x"], "unknown parameter 'device'; did you mean device_path?"),
        (["-p", "comm_t:=seriel"], "no transport 'seriel'; installed: mqtt, serial; did you mean"),
        (["--backend", "ros2"], "in a clone of rosbase: pip install ./packages/rosbase-ros2"),
    ],
)
def test_a_wrong_parameter_is_one_line_and_status_2(arguments: list[str], line: str) -> None:
    done = run_rosbase("imu", *arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert line in done.stderr


def test_plugins_answers_in_well_under_half_a_second() -> None:
    # Some machines are slower than others. These modules take 0.12 s where this command takes 0.3.
    modules = "argparse, asyncio, email.parser, http.client, inspect, json, logging.config, typing"
    yardstick = f"import {modules}, unittest.mock, xml.dom.minidom"

    def is_quick() -> bool:
        machine_s = least_cpu_s([sys.executable, "-c", yardstick])
        return least_cpu_s([ROSBASE, "plugins"]) < 3.5 * machine_s

    assert any(is_quick() for _ in range(3))


def test_autostart_goes_as_far_as_it_is_told(port: PluggablePort) -> None:
    port.plug()
    for autostart, state in (("none", "unconfigured"), ("configure", "inactive")):
        done = run_rosbase(
            "imu", "-p", f"device_path:={port.path}", "-p", f"autostart:={autostart}",
            "--duration", "1.5",
        )  # fmt: skip
        assert done.returncode == 0
        assert done.stdout.splitlines()[0] == state


def our_code_runs(pid: int) -> bool:
    """Whether the command has begun: Python ignores SIGPIPE and catches SIGINT, ours does not."""
    status = Path(f"/proc/{pid}/status").read_text()
    masks = {
        name: int(mask, 16)
        for name, mask in re.findall(r"^(Sig\w+):\s(\w+)$", status, re.MULTILINE)
    }
    ignores_pipe = masks["SigIgn"] >> (signal.SIGPIPE - 1) & 1
    catches_int = masks["SigCgt"] >> (signal.SIGINT - 1) & 1
    return bool(ignores_pipe and not catches_int)


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_at_any_early_moment_ends_it_without_a_traceback(
    port: PluggablePort, signum: int
) -> None:
    port.plug()
    too_early = 0
    for delay_ms in range(0, 300, 20):
        with RunningRosbase("imu", "-p", f"device_path:={port.path}") as reader:
            wait_until(partial(our_code_runs, reader.process.pid), "Python's own start")
            # Not to wait for something, but to come at another moment each time.
            time.sleep(delay_ms / 1000)
            status = reader.end(signum)
        is_interrupted = reader.err.count("Traceback") or reader.err.count("Fatal Python error")
        if is_interrupted and not reader.err.count("cli/run.py"):
            # Python's own start looks the same for a moment: after SIGPIPE, before SIGINT.
            too_early += 1
            continue
        assert status in (0, -signum), reader.err.lines
        assert reader.err.count("Traceback") == 0, reader.err.lines
    assert too_early < 5
    with RunningRosbase("imu", "-p", f"device_path:={port.path}") as reader:
        reader.waits_for("opened")
        assert reader.end(signum) == 0
    assert "published 0" in reader.out


def test_a_magnetic_field_is_echoed_too(port: PluggablePort) -> None:
    port.plug()
    with RunningRosbase(
        "imu", "-p", f"device_path:={port.path}", "-p", "preset:=custom", "--topic-echo",
        "-p", "mapping.magnetic_field.paths:=m", "-p", "mapping.magnetic_field.unit:=uT",
    ) as reader:  # fmt: skip
        reader.waits_for("opened")

        def arrives() -> bool:
            port.write(b'{"m":[1,2,3]}\n')
            return '"magnetic_field":' in reader.out

        wait_until(arrives, "a magnetic field")
        assert reader.end(signal.SIGINT) == 0


@pytest.mark.parametrize("is_quiet", [True, False])
def test_nobody_listens_to_samples_that_are_not_shown(*, is_quiet: bool) -> None:
    manager = ReaderManager({}, LogOutput(io.StringIO()), backend="local", is_quiet=is_quiet)
    assert (manager.monitor is None) == is_quiet
    manager.destroy_node()


@pytest.mark.parametrize("namespace", ["a//b", "1abc", "imu/", " ", "~x", "{x}", "ä", "a" * 300])
def test_a_bad_topic_namespace_is_one_line_and_status_2_before_the_device_is_opened(
    port: PluggablePort, namespace: str
) -> None:
    port.plug()
    done = run_rosbase(
        "imu", "-p", f"device_path:={port.path}", "-p", f"topic_namespace:={namespace}"
    )
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith("rosbase: parameter topic_namespace: ")


@pytest.mark.parametrize(
    "given", ["mqtt_topic:=lab/imu", "server_address:=tcp://broker", "tls_ca_file:=/ca.pem"]
)
def test_a_parameter_of_another_transport_is_named(port: PluggablePort, given: str) -> None:
    port.plug()
    done = run_rosbase("imu", "-p", f"device_path:={port.path}", "-p", given, "--duration", "0.3")
    name = given.partition(":=")[0]
    assert done.stderr.count(f"{name} has no effect: comm_t is serial") == 1


def test_a_frame_that_is_not_text_is_one_line_and_status_2(port: PluggablePort) -> None:
    port.plug()
    # As a terminal of another encoding gives it.
    done = run_rosbase("imu", "-p", f"device_path:={port.path}", "-p", "frame_id:=ger\udce4t")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "parameter frame_id: " in done.stderr
