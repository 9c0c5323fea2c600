"""What a machine must offer before ROS starts; shared memory in a mount namespace of its own."""

import ctypes
import json
import os
import signal
import subprocess
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rosbase import BackendError, BackendOptions, ConfigurationError
from rosbase_ros2 import imports, machine, starting
from rosbase_ros2.backend import Ros2Backend
from rosbase_ros2.machine import (
    DOMAINS,
    clashing_ports,
    domain_fault,
    free_bytes,
    memory_fault,
    read_domain,
    spare_shared_memory,
)
from support.command import ROSBASE, run_rosbase

FASTDDS = "rmw_fastrtps_cpp"
KB, MB = 1024, 1024**2

strtoul = ctypes.CDLL(None).strtoul
strtoul.restype = ctypes.c_ulong


def by_c(text: str) -> int:
    """What rcl makes of `ROS_DOMAIN_ID` (rcl/domain_id.c)."""
    return int(strtoul(text.encode(), None, 0))


@given(
    st.integers(-10, 300).map(str)
    | st.integers(0, 300).map(hex)
    | st.integers(0, 300).map(lambda number: f"0{number:o}")
    | st.text("0123456789abcfxX+- .\t", max_size=6)
)
@example("010")
@example(" 7 ")
@example("+7")
@example("08")
@example("4294967297")
def test_a_domain_is_read_as_ros_reads_it_or_not_at_all(text: str) -> None:
    domain = read_domain(text)
    if domain is not None:
        assert domain == by_c(text)
        assert domain in DOMAINS


@pytest.mark.parametrize("text", [str(number) for number in DOMAINS] + ["0x10", "010", " 7"])
def test_each_domain_is_one(text: str) -> None:
    assert domain_fault({"ROS_DOMAIN_ID": text}) == ""


# rcl takes most of these for some domain or other, without a word.
NO_DOMAINS = ["500", "233", "-2", "x", "7x", "1.5", "08", "4294967297", "1e2", "٣", " ", "9" * 5000]


@pytest.mark.parametrize("text", NO_DOMAINS, ids=lambda text: ascii(text)[:9])
def test_what_is_no_domain_is_said_with_the_range(text: str) -> None:
    fault = domain_fault({"ROS_DOMAIN_ID": text})
    assert fault == f"ROS_DOMAIN_ID is {text!r}, and a domain is a number from 0 to 232"


def test_no_domain_is_the_first() -> None:
    assert domain_fault({}) == domain_fault({"ROS_DOMAIN_ID": ""}) == ""


def test_domains_whose_ports_linux_gives_away_are_known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "_EPHEMERAL_PORTS", Path("/nowhere"))
    # As in the documentation of ROS for Linux.
    assert [d for d in DOMAINS if not clashing_ports(d)] == [*range(102), *range(215, 233)]


def test_the_range_of_ports_is_the_one_of_this_machine(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    file = tmp_path / "range"
    file.write_text("10000\t20000\n")
    monkeypatch.setattr(machine, "_EPHEMERAL_PORTS", file)
    assert [d for d in (0, 9, 10, 11, 50, 51, 150) if clashing_ports(d)] == [10, 11, 50]


@pytest.mark.parametrize("domain", ["500", "x", "-2"])
def test_a_backend_in_no_domain_is_one_line_before_ros_starts(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], domain: str
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    with pytest.raises(BackendError, match=f"ROS 2 does not start: ROS_DOMAIN_ID is '{domain}'"):
        Ros2Backend(BackendOptions("n"))
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("domain", ["500", "eleven"])
def test_the_command_in_no_domain_is_one_line_and_status_2(
    monkeypatch: pytest.MonkeyPatch, domain: str
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    done = run_rosbase("imu", "--backend", "ros2")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        f"rosbase: ROS 2 does not start: ROS_DOMAIN_ID is '{domain}',"
        " and a domain is a number from 0 to 232\n"
    )


# Shared memory.


def test_free_memory_is_that_of_the_file_system(monkeypatch: pytest.MonkeyPatch) -> None:
    state = SimpleNamespace(f_bavail=3, f_frsize=4096, f_files=100, f_favail=5)
    monkeypatch.setattr(os, "statvfs", lambda folder: state)
    assert free_bytes() == 3 * 4096
    # No more files, however much room there is.
    state.f_favail = 0
    assert free_bytes() == 0
    # A file system that does not count them.
    state.f_files = 0
    assert free_bytes() == 3 * 4096


def test_no_shared_memory_is_none_free(tmp_path: Path) -> None:
    assert free_bytes(tmp_path / "nowhere") == 0
    assert free_bytes(tmp_path) > 0


def test_with_enough_memory_nothing_is_changed() -> None:
    environment: dict[str, str] = {}
    assert spare_shared_memory(environment, FASTDDS, 2 * MB) == ""
    assert environment == {}


@pytest.mark.parametrize("free", [0, 64 * KB, 600 * KB, MB - 1])
def test_with_too_little_memory_udp_is_used_alone_and_a_line_says_so(free: int) -> None:
    environment = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
    assert memory_fault(environment, FASTDDS, free) == ""
    warning = spare_shared_memory(environment, FASTDDS, free)
    assert warning.endswith(" MB left, and Fast DDS needs 1 MB: it uses UDP alone")
    assert environment["FASTDDS_BUILTIN_TRANSPORTS"] == "UDPv4"
    # Once is enough: this is the choice that a child process inherits.
    assert spare_shared_memory(environment, FASTDDS, free) == ""


LOCAL = [{"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}, {"ROS_LOCALHOST_ONLY": "1"}]
CHOSEN = [{"FASTDDS_BUILTIN_TRANSPORTS": name} for name in ("DEFAULT", "LARGE_DATA", "SHM")]


@pytest.mark.parametrize("environment", LOCAL + CHOSEN, ids=str)
def test_where_the_transports_are_not_ours_to_choose_too_little_memory_is_refused(
    environment: dict[str, str],
) -> None:
    before = dict(environment)
    assert memory_fault(environment, FASTDDS, 2 * MB) == ""
    assert "or it loses messages; free some" in memory_fault(environment, FASTDDS, 600 * KB)
    # With next to none, Fast DDS does without by itself.
    assert memory_fault(environment, FASTDDS, 64 * KB) == ""
    assert spare_shared_memory(environment, FASTDDS, 64 * KB).endswith("it uses UDP alone")
    assert environment == before


@pytest.mark.parametrize(
    ("environment", "middleware"),
    [
        ({"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}, FASTDDS),
        ({"FASTDDS_BUILTIN_TRANSPORTS": "UDPv6"}, FASTDDS),
        ({"FASTRTPS_DEFAULT_PROFILES_FILE": "mine.xml"}, FASTDDS),
        ({"FASTDDS_DEFAULT_PROFILES_FILE": "mine.xml", **LOCAL[0]}, FASTDDS),
        ({}, "rmw_cyclonedds_cpp"),
    ],
)
def test_whoever_uses_none_or_says_how_is_left_alone(
    environment: dict[str, str], middleware: str
) -> None:
    before = dict(environment)
    for free in (0, 600 * KB):
        assert memory_fault(environment, middleware, free) == ""
        assert spare_shared_memory(environment, middleware, free) == ""
    assert environment == before


def test_a_backend_that_must_spare_memory_warns_of_it(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(starting, "free_bytes", lambda: 64 * KB)
    Ros2Backend(BackendOptions("n")).close()
    (record,) = caplog.records
    assert record.getMessage() == (
        "/dev/shm has 0.1 MB left, and Fast DDS needs 1 MB: it uses UDP alone"
    )


def test_full_memory_is_one_line_before_rclpy_ends_the_process(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def run(*args: Any, **options: Any) -> Any:
        return SimpleNamespace(returncode=-signal.SIGBUS)

    monkeypatch.setattr(imports, "free_bytes", lambda: 0)
    monkeypatch.setattr(subprocess, "run", run)
    with pytest.raises(ConfigurationError, match=r"/dev/shm is full \(0 bytes left\)"):
        imports.check_rclpy()


def test_little_memory_that_is_enough_for_rclpy_is_no_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(imports, "free_bytes", lambda: 0)
    imports.check_rclpy()


def _can_mount() -> bool:
    probe = ["unshare", "-m", "sh", "-c", "mount -t tmpfs tmpfs /dev/shm"]
    try:
        return subprocess.run(probe, check=False, capture_output=True).returncode == 0
    except OSError:
        return False


needs_mounts = pytest.mark.skipif(not _can_mount(), reason="mounting a file system is not allowed")


def run_with_memory(size: str, *command: str, fill_kb: int = 0) -> Any:
    """Runs a command with a /dev/shm of that size; the machine's own is not touched."""
    filling = f"head -c {fill_kb}k /dev/zero > /dev/shm/full;" if fill_kb else ""
    script = f'mount -t tmpfs -o size={size} tmpfs /dev/shm && {{ {filling} exec "$@"; }}'
    return subprocess.run(
        ["unshare", "-m", "sh", "-c", script, "sh", *command],
        check=False,
        capture_output=True,
        text=True,
        timeout=50,
    )


@needs_mounts
def test_on_a_machine_whose_memory_is_full_the_command_ends_with_a_line_and_status_2() -> None:
    done = run_with_memory("64k", ROSBASE, "imu", "--backend", "ros2", fill_kb=64)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "ROS 2 does not start: /dev/shm is full (0 bytes left)" in done.stderr


@needs_mounts
def test_the_doctor_says_that_memory_is_full() -> None:
    done = run_with_memory("64k", ROSBASE, "doctor", "--json", fill_kb=64)
    findings = [f for f in json.loads(done.stdout)["findings"] if f["check"] == "ros2"]
    assert (done.returncode, findings[0]["outcome"]) == (1, "fail")
    assert "/dev/shm is full" in findings[0]["text"]
    assert "fastdds shm clean" in findings[0]["advice"]


@needs_mounts
def test_on_a_machine_with_too_little_memory_it_does_not_start_and_lose_messages() -> None:
    # As `isolate` has it, nodes of this machine alone are seen.
    done = run_with_memory("700k", ROSBASE, "imu", "--backend", "ros2")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "/dev/shm has 0.7 MB left, and Fast DDS needs 1 MB, or it loses" in done.stderr
    told = run_with_memory("700k", ROSBASE, "doctor")
    assert "fail  ros2: no node can be started: ROS 2 does not start: /dev/shm has" in told.stdout


@needs_mounts
def test_on_a_machine_with_next_to_no_memory_it_runs_and_warns() -> None:
    done = run_with_memory("64k", ROSBASE, "imu", "--backend", "ros2", "--duration", "0.2")
    # The device is absent, so nothing is published.
    assert done.returncode == 1
    assert "/dev/shm has 0.1 MB left, and Fast DDS needs 1 MB: it uses UDP alone" in done.stderr
    told = run_with_memory("64k", ROSBASE, "doctor")
    assert "warn  ros2: /dev/shm has" in told.stdout
