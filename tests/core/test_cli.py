"""The command line with nothing but the core installed."""

import logging
import re
import subprocess
import sys
from pathlib import Path

import pytest

from rosbase.cli import main
from rosbase.cli.arguments import check_given, read_given
from rosbase.errors import ConfigurationError
from rosbase.imu.settings import READER_PARAMETERS, reader_parameters
from rosbase.plugins import installed_plugins
from support.command import run_apart as run
from support.plugins import BROKEN_PLUGINS, TRANSPORT_PLUGIN, install_plugin


def complaint(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """The one line that a refused command line ends with."""
    status: object
    try:
        status = main(list(arguments))
    except SystemExit as end:
        status = end.code
    shown = capsys.readouterr()
    assert (status, shown.out) == (2, "")
    assert shown.err.count("\n") == 1
    return shown.err.strip()


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["imu", "-p", "comm_t:=mqtt"], "pip install imu-mqtt"),
        (["imu", "-p", "comm_t:=carrier_pigeon"], "no transport 'carrier_pigeon'; installed:"),
        (["imu", "-p", "server_address:=x", "-p", "comm_t:=mqtt"], "pip install imu-mqtt"),
        (["imu", "-p", "comm_t:=[]"], "no transport '[]'"),
        (["imu", "-p", "frameid:=x", "-p", "comm_t:=none"], "no transport 'none'"),
        (["imu", "-p", "frame_id=x"], "-p takes name:=value, not 'frame_id=x'"),
        (["imu", "-p", "device_path:=x", "-p", "comm_t:=mqtt"], "pip install imu-mqtt"),
        (["imu", "--params-file", "/no/such.toml"], "/no/such.toml: No such file"),
        (["imu", "--params-file", "/"], "/: Is a directory"),
        (["imu", "--duration", "forever"], "'forever' is not a positive number"),
        (["imu", "--duration", "-1"], "'-1' is not a positive number"),
        (["imu", "--frobnicate"], "unrecognized arguments: --frobnicate"),
        (["demo", "--rate", "nan"], "'nan' is not a positive number"),
        (["demo", "--rate", "1e-308"], "'1e-308' is not from 0.01 to 100000"),
        (["demo", "--transport", "mqtt"], "pip install imu-mqtt"),
        (["fly"], "no command 'fly'; installed: completion, demo, doctor, imu, "),
        (["doctr"], "did you mean 'doctor'?"),
        (["doctor", "-p", "comm_t:=mqtt"], "pip install imu-mqtt"),
        (["doctor", "-p", "frameid:=x"], "unknown parameter 'frameid'"),
        ([], "give a command: completion, demo, doctor, imu, "),
    ],
)
def test_what_a_user_can_mend_is_one_line_and_status_2(
    capsys: pytest.CaptureFixture[str], arguments: list[str], line: str
) -> None:
    assert line in complaint(capsys, *arguments)


def test_parameters_come_from_a_file_and_the_command_line_wins(tmp_path: Path) -> None:
    file = tmp_path / "imu.toml"
    file.write_text(
        'frame_id = "left"\nstale_timeout = 2\norientation_stddev = 0.1\n'
        '[mapping.angular_velocity]\npaths = ["gx", "gy", "gz"]\nunit = "deg/s"\n'
    )
    assert check_given(READER_PARAMETERS, read_given(["frame_id:=right"], file)) == {
        "frame_id": "right",
        "stale_timeout": 2.0,
        "orientation_stddev": [0.1],
        "mapping.angular_velocity.paths": ["gx", "gy", "gz"],
        "mapping.angular_velocity.unit": "deg/s",
    }


@pytest.mark.parametrize(
    ("assignment", "line"),
    [
        ("frameid:=x", "unknown parameter 'frameid'; did you mean frame_id?"),
        ("stale_timeout:=1" + "0" * 350, "stale_timeout is too large a number"),
        ("stale_timeout:=soon", "stale_timeout takes a number, not 'soon'"),
        ("autostart:=yes", "autostart is one of none, configure, activate, not 'yes'"),
    ],
)
def test_a_bad_assignment_is_one_line(assignment: str, line: str) -> None:
    with pytest.raises(ConfigurationError, match=re.escape(line)):
        check_given(READER_PARAMETERS, read_given([assignment], None))


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("frame_id = ", "Invalid value"),
        ("frame_idd = 'x'", "unknown parameter 'frame_idd'"),
        ("[mapping.gyro]\nunit = 'x'", "unknown parameter 'mapping.gyro.unit'"),
        ("frame_id = 2020-01-01", "frame_id takes text"),
        ("[frame_id]", "frame_id takes text"),
        ("a=" + "[" * 5000 + "]" * 5000, "nested too deeply|unknown parameter"),
        (".".join("a" * 3000) + "=1", "nested too deeply|unknown parameter"),
    ],
)
def test_a_bad_parameter_file_is_one_line(tmp_path: Path, text: str, line: str) -> None:
    file = tmp_path / "imu.toml"
    file.write_text(text)
    with pytest.raises(ConfigurationError, match=line) as caught:
        check_given(READER_PARAMETERS, read_given([], file))
    assert "\n" not in str(caught.value)


def test_a_parameter_file_that_is_not_text_is_one_line(tmp_path: Path) -> None:
    file = tmp_path / "imu.toml"
    file.write_bytes(b"\xff\xfe")
    with pytest.raises(ConfigurationError, match=r"imu\.toml: "):
        check_given(READER_PARAMETERS, read_given([], file))


def test_plugins_lists_what_each_brings(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plugins"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith("local") and "backend: local" in line for line in lines)
    assert all(" active " in line for line in lines)


def test_broken_plugins_are_listed_with_the_reason_and_the_rest_works(tmp_path: Path) -> None:
    for fault, (code, _) in BROKEN_PLUGINS.items():
        install_plugin(tmp_path, f"broken-{fault.replace('_', '-')}", fault, code)
    for owner in ("first", "second"):
        install_plugin(tmp_path, owner, "radio", TRANSPORT_PLUGIN.format(name="radio"))
    listed = run("plugins", path=tmp_path)
    assert (listed.returncode, listed.stderr) == (0, "")
    lines = {line.split()[0]: line for line in listed.stdout.splitlines()}
    for fault, (_, reason) in BROKEN_PLUGINS.items():
        assert " failed " in lines[fault]
        assert reason in lines[fault]
    assert listed.stdout.count("transport 'radio' is claimed by first:radio and second:radio") == 2
    assert " active " in lines["local"]


CLASHING = """
from rosbase.parameters import ParameterSpec
from rosbase.plugins import PresetPlugin, TransportPlugin, CommandPlugin, hookimpl

@hookimpl
def rosbase_transports():
    yield TransportPlugin("clashing", "a test", print, parameters=(ParameterSpec("frame_id", 5),))

@hookimpl
def rosbase_presets():
    yield PresetPlugin("odd", "a test", {"bogus.key": 1})

def configure(parser):
    raise RuntimeError("no arguments today")

@hookimpl
def rosbase_commands():
    yield CommandPlugin("fly", "100% of a test", configure, print)
"""


def test_a_plugin_that_contradicts_the_reader_is_listed_and_harms_nobody(tmp_path: Path) -> None:
    install_plugin(tmp_path, "clasher", "clash", CLASHING)
    listed = run("plugins", path=tmp_path)
    (line,) = [line for line in listed.stdout.splitlines() if line.startswith("clash")]
    assert " failed " in line
    assert "its parameter frame_id differs from that of the reader" in line
    assert run("imu", "--list-parameters", path=tmp_path).returncode == 0
    assert run("--help", path=tmp_path).returncode == 0
    for arguments, complaint in (
        (["imu", "-p", "comm_t:=clashing"], "transport 'clashing' cannot be used"),
        (["imu", "-p", "comm_t:=clashing", "-p", "preset:=odd"], "transport 'clashing' cannot"),
        (["fly"], "the command 'fly' is broken: RuntimeError('no arguments today')"),
    ):
        done = run(*arguments, path=tmp_path)
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
        assert complaint in done.stderr


@pytest.mark.parametrize("closed", ["1>&-", "2>&-", "1>&- 2>&-"])
def test_closed_standard_streams_are_no_reason_to_fail(closed: str) -> None:
    code = "import sys; from rosbase.cli import main; sys.exit(main())"
    command = f"exec '{sys.executable}' -c '{code}' plugins {closed}"
    done = subprocess.run(command, shell=True, capture_output=True, timeout=30, check=False)
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_full_disk_is_one_line_and_status_1() -> None:
    code = "import sys; from rosbase.cli import main; sys.exit(main())"
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-c", code, "plugins"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            timeout=30,
            check=False,
        )
    assert done.returncode == 1
    assert done.stderr == "rosbase: cannot write: No space left on device\n"


LIGHT = """
import sys
{code}
heavy = {{"serial", "paho", "rclpy", "ssl", "http", "asyncio", "multiprocessing", {more}}}
print(sorted(heavy & set(sys.modules)))
"""


@pytest.mark.parametrize(
    ("code", "more"),
    [
        ("import rosbase", "'socket', 'pluggy', 'importlib.metadata'"),
        # Here the standard library's importlib.metadata brings `socket` in, by way of `email`.
        ("from rosbase.cli import main; main(['plugins'])", "'rosbase.imu.reader'"),
    ],
)
def test_importing_rosbase_and_listing_plugins_stay_light(code: str, more: str) -> None:
    shown = subprocess.run(
        [sys.executable, "-c", LIGHT.format(code=code, more=more)],
        capture_output=True,
        text=True,
        timeout=30,
        check=True,
    )
    assert shown.stdout.splitlines()[-1] == "[]"


def test_the_version_is_that_of_the_distribution(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == "rosbase-core 0.1.0\n"


def test_the_command_can_be_asked_of_a_python_by_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["plugins"])
    shown = subprocess.run(
        [sys.executable, "-m", "rosbase", "plugins"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=30,
        check=True,
    )
    assert shown.stdout == capsys.readouterr().out
    refused = subprocess.run(
        [sys.executable, "-m", "rosbase"],
        cwd=tmp_path,
        capture_output=True,
        timeout=30,
        check=False,
    )
    assert refused.returncode == 2


def test_the_parameters_can_be_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["imu", "--list-parameters"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[:2] == ["most used", f"  {'comm_t:=serial':44}  the transport, by name"]
    assert f"  {'autostart:=activate':44}  how far the node goes by itself" in lines
    assert "payload mapping" in lines
    # What it shows can be given back.
    shown = [line[2:].partition("  ")[0] for line in lines if ":=" in line and "=[]" not in line]
    check_given(reader_parameters(installed_plugins()), read_given(shown, None))
    assert logging.getLogger("rosbase").handlers
