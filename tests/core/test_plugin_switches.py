"""What the environment says of plugins: blocked ones, strictness, the trace of hooks."""

import sys
from pathlib import Path

import pytest

from rosbase.errors import ConfigurationError, NotInstalledError, PluginError
from rosbase.plugins import PluginRegistry
from rosbase.plugins.switches import PluginSwitches
from support.command import run_apart
from support.plugins import (
    CONVERSION_PLUGIN,
    TRANSPORT_PLUGIN,
    candidates_in,
    install_plugin,
)

RADIO = TRANSPORT_PLUGIN.format(name="radio")
CLASHING = RADIO.replace("create)", "create, parameters=(ParameterSpec('frame_id', 5),))").replace(
    "from rosbase", "from rosbase.parameters import ParameterSpec\nfrom rosbase", 1
)


def load(site: Path, *blocked: str, is_strict: bool = False) -> PluginRegistry:
    return PluginRegistry(candidates_in(site), PluginSwitches(blocked, is_strict=is_strict))


@pytest.mark.parametrize("name", ["radio", "acme-radio", "Acme_Radio", "acme-radio:radio"])
def test_a_blocked_plugin_is_not_even_imported_and_the_others_work(site: Path, name: str) -> None:
    install_plugin(site, "acme-radio", "radio", "raise SystemExit")
    install_plugin(site, "z-good", "can", TRANSPORT_PLUGIN.format(name="can"))
    registry = load(site, name)
    blocked, good = registry.plugins
    assert (blocked.status, blocked.descriptors, good.status) == ("blocked", (), "active")
    assert "acme_radio_radio" not in sys.modules
    assert set(registry.transports) == {"can"}


def test_of_two_plugins_of_one_name_one_can_be_blocked(site: Path) -> None:
    for owner in ("first", "second"):
        install_plugin(site, owner, "radio", RADIO)
    registry = load(site, "first:radio")
    assert registry.owner_of(registry.transport("radio")).distribution == "second"


def test_a_name_that_nobody_has_is_a_warning_in_one_line(
    site: Path, caplog: pytest.LogCaptureFixture
) -> None:
    install_plugin(site, "acme", "radio", RADIO)
    assert set(load(site, "raido").transports) == {"radio"}
    (record,) = caplog.records
    assert record.levelname == "WARNING"
    assert record.getMessage() == "ROSBASE_BLOCK_PLUGINS: no installed plugin is called 'raido'"


def test_who_asks_for_what_is_blocked_is_told_so_and_by_what(site: Path) -> None:
    install_plugin(site, "acme", "radio", RADIO)
    install_plugin(site, "imu-serial", "wired", TRANSPORT_PLUGIN.format(name="serial"))
    registry = load(site, "acme", "imu-serial")
    for name, owner in (("radio", "acme:radio"), ("serial", "imu-serial:wired")):
        with pytest.raises(NotInstalledError) as caught:
            registry.transport(name)
        assert str(caught.value) == (
            f"transport '{name}' cannot be used: {owner} is blocked by ROSBASE_BLOCK_PLUGINS"
        )


def test_what_a_blocked_plugin_would_bring_is_unknown_so_it_is_named(site: Path) -> None:
    install_plugin(site, "acme", "radio", RADIO)
    with pytest.raises(NotInstalledError) as caught:
        load(site, "acme").preset("acme9")
    assert str(caught.value) == (
        "no preset 'acme9'; installed: none; blocked by ROSBASE_BLOCK_PLUGINS: acme:radio"
    )


def test_a_conversion_that_is_blocked_is_not_said_to_be_unknown(site: Path) -> None:
    code = CONVERSION_PLUGIN.format(create="return 1", msg_type="Force")
    install_plugin(site, "arm", "force", code)
    force = type("Force", (), {"__module__": "arm_force"})
    with pytest.raises(PluginError, match="arm:force is blocked by ROSBASE_BLOCK_PLUGINS"):
        load(site, "arm").create_conversion(force, "ros2", print)


@pytest.mark.parametrize("name", ["local", "rosbase-core", "rosbase_core", "rosbase-core:cli"])
def test_the_core_cannot_be_blocked_and_says_so_in_one_line(name: str) -> None:
    done = run_apart("plugins", ROSBASE_BLOCK_PLUGINS=name)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        f"rosbase: ROSBASE_BLOCK_PLUGINS: {name!r} is a part of rosbase-core,"
        " which cannot be blocked\n"
    )


def test_a_name_that_the_core_has_too_blocks_the_other(site: Path) -> None:
    install_plugin(site, "rosbase-core", "imu", TRANSPORT_PLUGIN.format(name="can"))
    install_plugin(site, "acme", "imu", RADIO)
    assert set(load(site, "imu").transports) == {"can"}


def test_blocked_plugins_are_listed_as_blocked_and_empty_names_mean_nothing(
    tmp_path: Path,
) -> None:
    install_plugin(tmp_path, "acme", "radio", RADIO)
    done = run_apart("plugins", path=tmp_path, ROSBASE_BLOCK_PLUGINS=" radio ,, ")
    assert (done.returncode, done.stderr) == (0, "")
    assert "radio  blocked  acme 1.2  by ROSBASE_BLOCK_PLUGINS\n" in done.stdout


def test_a_blocked_command_is_refused_in_one_line(tmp_path: Path) -> None:
    install_plugin(tmp_path, "acme", "fly", "raise SystemExit")
    done = run_apart("fly", path=tmp_path, ROSBASE_BLOCK_PLUGINS="acme")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "command 'fly' cannot be used: acme:fly is blocked by ROSBASE" in done.stderr


def test_a_plugin_that_fails_is_an_error_if_the_user_is_strict(site: Path) -> None:
    install_plugin(site, "acme", "radio", "import no_such_library")
    for owner in ("first", "second"):
        install_plugin(site, owner, "can", TRANSPORT_PLUGIN.format(name="can"))
    with pytest.raises(PluginError) as caught:
        load(site, is_strict=True)
    said = str(caught.value)
    assert said.startswith("acme:radio failed: ModuleNotFoundError: No module named 'no_such_")
    assert "second:can failed: transport 'can' is claimed by" in said
    assert said.endswith("(ROSBASE_STRICT_PLUGINS is set)")
    assert load(site, "acme", "first", is_strict=True).transport("can")


@pytest.mark.parametrize("code", ["import no_such_library", CLASHING], ids=["broken", "clashing"])
@pytest.mark.parametrize("command", ["plugins", "imu", "doctor"])
def test_on_the_command_line_strictness_is_one_line_and_status_2(
    tmp_path: Path, code: str, command: str
) -> None:
    install_plugin(tmp_path, "acme", "radio", code)
    done = run_apart(command, path=tmp_path, ROSBASE_STRICT_PLUGINS="1")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith("rosbase: acme:radio failed: ")


def test_the_trace_says_which_hook_of_which_plugin_gave_what(tmp_path: Path) -> None:
    install_plugin(tmp_path, "acme", "radio", RADIO)
    late = (
        "from rosbase.plugins import hookimpl\n@hookimpl\n"
        "def rosbase_presets():\n    yield from ()\n    raise OSError('no\\nluck')"
    )
    install_plugin(tmp_path, "bad", "late", late)
    plain = run_apart("plugins", path=tmp_path)
    traced = run_apart("plugins", path=tmp_path, ROSBASE_TRACE_HOOKS="TRUE")
    assert plain.stderr == ""
    assert traced.stdout == plain.stdout
    lines = traced.stderr.splitlines()
    assert all(line.startswith("rosbase hooks: ") for line in lines)
    assert [line for line in lines if " acme:" in line] == [
        "rosbase hooks: acme:radio rosbase_transports is called",
        "rosbase hooks: acme:radio rosbase_transports gave transport 'radio'",
    ]
    assert [line for line in lines if " bad:" in line] == [
        "rosbase hooks: bad:late rosbase_presets is called",
        "rosbase hooks: bad:late failed: OSError: no luck",
    ]
    assert "rosbase hooks: rosbase-core:local rosbase_backends gave backend 'local'" in lines


def test_a_trace_that_nobody_can_hear_harms_no_plugin(
    site: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install_plugin(site, "acme", "radio", RADIO)
    with open("/dev/full", "w", buffering=1) as full:
        monkeypatch.setattr(sys, "stderr", full)
        registry = PluginRegistry(candidates_in(site), PluginSwitches(traces=True))
        monkeypatch.undo()
        assert [record.status for record in registry.plugins] == ["active"]
        with pytest.raises(OSError, match="No space"):
            full.close()


@pytest.mark.parametrize("variable", ["ROSBASE_STRICT_PLUGINS", "ROSBASE_TRACE_HOOKS"])
def test_a_switch_is_on_or_off_and_anything_else_is_one_line(
    monkeypatch: pytest.MonkeyPatch, variable: str
) -> None:
    def read() -> PluginSwitches:
        return PluginSwitches.from_environment()

    for text, is_on in {"": False, "0": False, "False": False, "1": True, "true": True}.items():
        monkeypatch.setenv(variable, text)
        assert (read().is_strict or read().traces) == is_on
    monkeypatch.setenv(variable, "yes")
    with pytest.raises(ConfigurationError, match=f"^{variable} is 0, 1, false or true, not 'yes'$"):
        read()
