"""What `rosbase doctor` says of serial ports. The list of ports is played: ours is on no list."""

import fcntl
import grp
import os
import subprocess
import sys
from pathlib import Path

import pytest

from imu_serial import check
from imu_serial.check import check_ports
from imu_serial.config import PARAMETERS
from rosbase.clock import SystemClock
from rosbase.contracts.checks import CheckContext, Finding, Outcome
from support.port_holder import hold
from support.serial_network import Rfc2217Peer, SocketPeer
from support.serial_rig import SerialRig

DEFAULTS = {"comm_t": "serial", **{spec.name: spec.default for spec in PARAMETERS}}


def findings(**given: str) -> list[Finding]:
    return list(check_ports(CheckContext(SystemClock(), DEFAULTS | given, frozenset(given))))


@pytest.fixture(autouse=True)
def ports(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The ports that this machine is said to have."""
    ports: list[str] = []
    monkeypatch.setattr(check, "port_names", lambda: ports)
    monkeypatch.setitem(DEFAULTS, "device_path", "/dev/no-such-default")
    return ports


@pytest.fixture
def port(rig: SerialRig) -> str:
    """A port that is plugged in, under its link; nobody but this process has it open."""
    rig.port.plug()
    return str(rig.port.path)


def test_a_port_that_is_named_is_opened_and_given_back(port: str) -> None:
    for _ in range(2):
        (found,) = findings(device_path=port)
        assert (found.outcome, found.text) == (
            Outcome.OK,
            f"{port} at 115200 baud can be opened",
        )


def test_an_absent_port_fails_and_those_that_are_there_are_named(
    port: str, ports: list[str], tmp_path: Path
) -> None:
    ports.append(port)
    absent, other = findings(device_path=str(tmp_path / "absent"))
    assert absent.outcome is Outcome.FAIL
    assert "is not there; is the device plugged in?" in absent.text
    assert port in absent.advice
    assert other == Finding(Outcome.OK, f"{port} exists, and this user may open it")


@pytest.mark.parametrize("path", ["", "/", "/dev/null", "/dev/a\nb"])
def test_a_name_that_is_no_port_fails_in_one_line(path: str) -> None:
    (found,) = findings(device_path=path)
    assert found.outcome is Outcome.FAIL
    assert found.advice


def test_a_device_of_another_kind_is_no_port_whoever_has_it_open() -> None:
    with open("/dev/null"), subprocess.Popen(["sleep", "60"], stdin=subprocess.DEVNULL) as other:
        (found,) = findings(device_path="/dev/null")
        other.kill()
    assert "not a serial port" in found.text


def test_where_none_is_named_the_default_or_the_ports_that_are_there_count(
    port: str, ports: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (nothing,) = findings()
    assert (nothing.outcome, nothing.text) == (Outcome.WARN, "this machine has no serial port")
    ports.append(port)
    absent, there = findings()
    assert (absent.outcome, there.outcome) == (Outcome.WARN, Outcome.OK)
    assert absent.advice == f"set yours: -p device_path:={port}"
    monkeypatch.setitem(DEFAULTS, "device_path", port)
    assert [found.outcome for found in findings()] == [Outcome.OK]


def test_ports_are_no_matter_where_another_transport_is_chosen() -> None:
    assert findings(comm_t="mqtt") == []


def test_a_port_that_nobody_has_named_is_not_opened_because_that_resets_boards(
    port: str, ports: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def opened(config: object) -> None:
        raise AssertionError("opened")

    monkeypatch.setattr(check, "Port", opened)
    monkeypatch.setitem(DEFAULTS, "device_path", port)
    ports.append(os.path.realpath(port))
    assert [found.outcome for found in findings()] == [Outcome.OK]


HOLDER = "import os, sys; fd = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY); print(fd); input()"


@pytest.mark.parametrize(("is_named", "outcome"), [(True, Outcome.FAIL), (False, Outcome.WARN)])
def test_who_has_a_port_open_is_named_and_not_disturbed(
    port: str, ports: list[str], is_named: bool, outcome: Outcome
) -> None:
    ports.append(port)
    command = [sys.executable, "-c", HOLDER, port]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline()
        found = findings(device_path=port)[0] if is_named else findings()[-1]
        holder.communicate(b"\n")
    assert found.outcome is outcome
    assert found.text.startswith(f"{port} is in use by process {holder.pid} (")
    (free,) = findings(device_path=port)
    assert free.outcome is Outcome.OK


def test_a_port_that_another_has_locked_fails(port: str) -> None:
    fd = os.open(port, os.O_RDWR | os.O_NOCTTY)
    fcntl.flock(fd, fcntl.LOCK_EX)
    # Its own process is no other program; the lock is what counts here.
    (found,) = findings(device_path=port)
    os.close(fd)
    assert (found.outcome, found.text) == (Outcome.FAIL, f"{port} is in use by another program")
    assert "fuser" in found.advice


AS_NOBODY = """
import grp, os, pwd, sys
from imu_serial import check
from imu_serial.config import PARAMETERS
from rosbase.contracts.checks import CheckContext
from rosbase.clock import SystemClock
if os.getuid() == 0:
    os.setgroups([])
    os.setgid(65534)
    os.setuid(65534)
me = pwd.getpwuid(os.getuid()).pw_name
{more}
values = {{"comm_t": "serial", **{{spec.name: spec.default for spec in PARAMETERS}}}}
values["device_path"] = named = {named!r}
check.port_names = lambda: [{port!r}]
# Other tests run programs of these names at the same time.
check.running_takers = lambda: ()
found = list(check.check_ports(CheckContext(SystemClock(), values, frozenset({given!r}))))
print(me, *(f"{{f.outcome.value}}|{{f.text}}|{{f.advice}}" for f in found), sep="\\n")
"""


def as_nobody(port: str, named: str = "", more: str = "") -> tuple[str, list[list[str]]]:
    """What a user without privileges is told of a port, named or not: their name, the findings."""
    given = ["device_path"] if named else []
    code = AS_NOBODY.format(more=more, named=named or "/dev/none", port=port, given=given)
    shown = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=30, check=True
    )
    me, *found = shown.stdout.splitlines()
    return me, [line.split("|") for line in found]


def give_to_a_group(path: str, mode: int) -> str:
    """Lets the members of a group have the port, and nobody else; the name of the group."""
    group = next(group for group in grp.getgrall() if group.gr_gid not in (0, 65534))
    if os.getuid() == 0:
        os.chown(path, -1, group.gr_gid)
    os.chmod(path, mode)
    return grp.getgrgid(os.stat(path).st_gid).gr_name


def test_the_missing_group_is_named_with_the_command_that_adds_it(rig: SerialRig) -> None:
    rig.port.plug()
    port = rig.port.real_path
    group = give_to_a_group(port, 0o060)
    me, ((outcome, text, advice),) = as_nobody(port, named=port)
    assert outcome == "fail"
    assert text == f"{me} may not open {port}, which belongs to the group {group}"
    assert advice == f"sudo usermod -aG {group} {me}, then log out and in again"


def test_a_forbidden_port_that_nobody_has_named_is_a_warning(rig: SerialRig) -> None:
    rig.port.plug()
    give_to_a_group(rig.port.real_path, 0o060)
    _, (unnamed, (outcome, text, advice)) = as_nobody(rig.port.real_path)
    assert (unnamed[0], outcome) == ("warn", "warn")
    assert rig.port.real_path in text
    assert "usermod" in advice


JOINED = "grp.getgrgid = lambda gid: grp.struct_group(('joined', 'x', gid, [me]))"


def test_who_has_joined_the_group_and_not_logged_in_again_is_told_to(rig: SerialRig) -> None:
    rig.port.plug()
    port = rig.port.real_path
    give_to_a_group(port, 0o060)
    me, ((outcome, _, advice),) = as_nobody(port, named=port, more=JOINED)
    assert outcome == "fail"
    assert advice == f"{me} was added to that group: log out and in again"


def test_no_group_is_advised_where_a_group_does_not_help(rig: SerialRig) -> None:
    rig.port.plug()
    port = rig.port.real_path
    give_to_a_group(port, 0)
    _, ((outcome, _, advice),) = as_nobody(port, named=port)
    assert outcome == "fail"
    assert f"sudo chmod a+rw {port}" in advice


def test_modemmanager_and_brltty_are_named_before_anything_fails(
    port: str, ports: list[str]
) -> None:
    ports.append(port)
    with hold("/dev/null", "ModemManager") as modem, hold("/dev/null", "brltty") as braille:
        found = {f.text: f for f in findings() if "running" in f.text}
        named = [f.text for f in findings(device_path=port) if "running" in f.text]
    for process, remedy in ((modem, "ID_MM_DEVICE_IGNORE"), (braille, "apt remove brltty")):
        (text,) = [text for text in found if f"process {process.pid} " in text]
        assert found[text].outcome is Outcome.WARN
        assert remedy in found[text].advice
        assert text in named
    assert [f for f in findings() if "running" in f.text] == []


def test_no_program_is_suspected_where_no_serial_port_is_read(port: str, ports: list[str]) -> None:
    with hold("/dev/null", "ModemManager"):
        assert [f.outcome for f in findings(comm_t="mqtt")] == []
        assert [f.outcome for f in findings(device_path="socket://127.0.0.1:1")] == [Outcome.FAIL]


def test_a_known_taker_that_has_the_port_is_named_with_its_remedy(port: str) -> None:
    with hold(os.path.realpath(port), "ModemManager"):
        (found, *_) = findings(device_path=port)
    assert "(ModemManager)" in found.text
    assert "ID_MM_DEVICE_IGNORE" in found.advice


@pytest.fixture
def latency_timer(port: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The timer of an adapter behind the port, as FTDI's driver shows it."""
    monkeypatch.setattr(check, "_LATENCY_TIMERS", tmp_path)
    folder = tmp_path / os.path.basename(os.path.realpath(port))
    folder.mkdir()
    (folder / "latency_timer").write_text("16\n")
    return folder / "latency_timer"


def test_a_long_latency_timer_is_said_with_how_to_shorten_it(
    port: str, ports: list[str], latency_timer: Path
) -> None:
    _, slow = findings(device_path=port)
    assert slow.outcome is Outcome.WARN, "it is long although it has been opened"
    assert slow.text == f"{port} delivers data only every 16 ms, also for a reader"
    assert f"echo 1 | sudo tee {latency_timer}" in slow.advice
    ports.append(port)
    (quiet,) = [f for f in findings() if "every 16 ms" in f.text]
    assert quiet.outcome is Outcome.OK
    assert quiet.text.endswith("until it is read")


@pytest.mark.parametrize("content", ["1\n", "2\n", "", "x"])
def test_a_short_latency_timer_or_none_is_no_matter(
    port: str, latency_timer: Path, content: str
) -> None:
    latency_timer.write_text(content)
    assert len(findings(device_path=port)) == 1
    latency_timer.unlink()
    assert len(findings(device_path=port)) == 1


@pytest.mark.parametrize("kind", [SocketPeer, Rfc2217Peer])
def test_a_port_on_a_network_is_reached_and_left(kind: type[SocketPeer]) -> None:
    peer = kind()
    for _ in range(2):
        (found,) = findings(device_path=peer.url)
        assert found.outcome is Outcome.OK
        assert found.text.startswith(peer.url)
        assert found.text.endswith("can be reached")
    peer.close()


@pytest.mark.parametrize(
    ("scheme", "advice"),
    [("socket", "socat TCP-LISTEN:{},"), ("rfc2217", "accepter: telnet(rfc2217),tcp,{}")],
)
def test_a_port_on_a_network_that_is_not_there_fails_with_what_to_run(
    scheme: str, advice: str
) -> None:
    peer = SocketPeer()
    peer.close()
    (found,) = findings(device_path=f"{scheme}://127.0.0.1:{peer.port}")
    assert found.outcome is Outcome.FAIL
    assert "nothing listens there" in found.text
    assert advice.format(peer.port) in found.advice
    assert "plug" not in found.text + found.advice


@pytest.mark.parametrize("path", ["tcp://host:1", "socket://host", "loop://"])
def test_an_address_that_cannot_be_fails_in_one_line(path: str) -> None:
    (found,) = findings(device_path=path)
    assert (found.outcome, found.text[:11]) == (Outcome.FAIL, "device_path")
    assert found.advice


def test_a_name_of_windows_fails_with_the_ports_that_are_there(
    ports: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    ports.append("/dev/ttyUSB3")
    monkeypatch.setattr("imu_serial.refusals.port_names", lambda: ports)
    (found, *_) = findings(device_path="COM4")
    assert found.outcome is Outcome.FAIL
    assert "on Windows; here there are /dev/ttyUSB3" in found.text
