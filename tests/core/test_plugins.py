import sys
from argparse import Namespace
from importlib.metadata import PathDistribution
from pathlib import Path
from typing import Any

import pytest

from rosbase.cli.list_plugins import run as list_plugins
from rosbase.errors import NotInstalledError, PluginError
from rosbase.plugins import PluginRegistry, installed_plugins
from rosbase.plugins.discovery import find_candidates
from rosbase.plugins.our_packages import how_to_install
from support.plugins import (
    BROKEN_PLUGINS,
    CONVERSION_PLUGIN,
    TRANSPORT_PLUGIN,
    candidates_in,
    install_plugin,
)


def load(site: Path) -> PluginRegistry:
    return PluginRegistry(candidates_in(site))


@pytest.mark.parametrize("fault", BROKEN_PLUGINS)
def test_a_broken_plugin_is_recorded_and_the_others_work(site: Path, fault: str) -> None:
    code, reason = BROKEN_PLUGINS[fault]
    install_plugin(site, "a-good", "udp", TRANSPORT_PLUGIN.format(name="udp"))
    install_plugin(site, "b-broken", fault, code)
    install_plugin(site, "c-good", "can", TRANSPORT_PLUGIN.format(name="can"))
    registry = load(site)
    assert set(registry.transports) == {"udp", "can"}
    (broken,) = [record for record in registry.plugins if record.failure]
    assert (broken.distribution, broken.version, broken.descriptors) == ("b-broken", "1.2", ())
    assert reason in broken.failure
    assert "\n" not in broken.failure


def test_what_a_plugin_prints_while_it_is_loaded_is_not_what_the_command_prints(
    site: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code = "print('welcome')\n" + TRANSPORT_PLUGIN.format(name="udp")
    install_plugin(site, "acme", "udp", code)
    assert set(load(site).transports) == {"udp"}
    assert capsys.readouterr() == ("", "welcome\n")


def test_a_name_of_a_plugin_that_failed_leads_to_the_reason(site: Path) -> None:
    install_plugin(site, "acme", "udp", "import acme_radio\n")
    with pytest.raises(NotInstalledError) as caught:
        load(site).transport("udp")
    why = "acme:udp failed: ModuleNotFoundError: No module named 'acme_radio'"
    assert str(caught.value) == f"transport 'udp' cannot be used: {why}"


def test_all_kinds_of_broken_plugins_together_harm_nobody(site: Path) -> None:
    for fault, (code, _) in BROKEN_PLUGINS.items():
        install_plugin(site, f"broken-{fault.replace('_', '-')}", fault, code)
    install_plugin(site, "z-good", "can", TRANSPORT_PLUGIN.format(name="can"))
    registry = load(site)
    assert set(registry.transports) == {"can"}
    assert len([r for r in registry.plugins if r.failure]) == len(BROKEN_PLUGINS)


def test_a_distribution_without_its_metadata_is_listed_and_harms_nobody(site: Path) -> None:
    install_plugin(site, "bare", "x", TRANSPORT_PLUGIN.format(name="x"))
    (site / "bare-1.2.dist-info" / "METADATA").unlink()
    install_plugin(site, "damaged", "y", TRANSPORT_PLUGIN.format(name="y"))
    (site / "damaged-1.2.dist-info" / "entry_points.txt").write_text("[rosbase]\ny damaged_y\n")
    install_plugin(site, "undecodable", "u", TRANSPORT_PLUGIN.format(name="u"))
    (site / "undecodable-1.2.dist-info" / "entry_points.txt").write_bytes(b"[x]\n\xff = a:b\n")
    install_plugin(site, "endless", "e", TRANSPORT_PLUGIN.format(name="e"))
    loop = site / "endless-1.2.dist-info" / "entry_points.txt"
    loop.unlink()
    loop.symlink_to(loop)
    install_plugin(site, "z-good", "can", TRANSPORT_PLUGIN.format(name="can"))
    registry = load(site)
    assert "can" in registry.transports
    failures = {record.distribution: record.failure for record in registry.plugins}
    assert set(failures) == {"bare", "damaged", "undecodable", "endless", "z-good"}
    assert "metadata cannot be read" in failures["undecodable"]
    assert "metadata cannot be read" in failures["endless"]
    assert "metadata cannot be read" in failures["damaged"]


def test_only_distributions_with_plugins_are_read(
    site: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install_plugin(site, "good", "x", TRANSPORT_PLUGIN.format(name="x"))
    for number in range(20):
        info = site / f"other_{number}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Name: other-{number}\nVersion: 1.0\n")
    read: list[str] = []
    original = PathDistribution.read_text

    def read_text(distribution: Any, filename: Any) -> str | None:
        if filename == "METADATA":
            read.append(distribution._path.name)
        return original(distribution, filename)

    monkeypatch.setattr(PathDistribution, "read_text", read_text)
    assert [found.full_name for found in candidates_in(site)] == ["good:x"]
    assert set(read) == {"good-1.2.dist-info"}


@pytest.mark.parametrize(
    "folder", ["a_radio-2.0.dist-info", "A.Radio-2.0.dist-info", "a_radio.egg-info"]
)
def test_the_first_of_two_distributions_of_one_name_counts(
    site: Path, tmp_path: Path, folder: str
) -> None:
    install_plugin(site, "a-radio", "radio", TRANSPORT_PLUGIN.format(name="radio"))
    first = tmp_path / "first"
    (first / folder).mkdir(parents=True)
    paths = [str(first), str(site)]
    assert find_candidates("rosbase", paths) == []
    assert [found.full_name for found in find_candidates("rosbase", paths[::-1])] == [
        "a-radio:radio"
    ]


def test_a_name_claimed_by_two_is_refused_with_both_names(site: Path) -> None:
    install_plugin(site, "a-radio", "radio", TRANSPORT_PLUGIN.format(name="radio"))
    install_plugin(site, "b-radio", "radio", TRANSPORT_PLUGIN.format(name="radio"))
    registry = load(site)
    for record in registry.plugins:
        assert record.failure == "transport 'radio' is claimed by a-radio:radio and b-radio:radio"
    with pytest.raises(NotInstalledError, match="claimed by a-radio:radio and b-radio:radio"):
        registry.transport("radio")


def test_a_name_of_this_project_stays_with_its_package(site: Path) -> None:
    install_plugin(site, "a-usurper", "x", TRANSPORT_PLUGIN.format(name="serial"))
    install_plugin(site, "imu-serial", "serial", TRANSPORT_PLUGIN.format(name="serial"))
    registry = load(site)
    usurper, owner = registry.plugins
    assert "a-usurper:x and imu-serial:serial" in usurper.failure
    assert not owner.failure
    assert set(registry.transports) == {"serial"}


def test_a_name_of_this_project_cannot_be_taken_in_its_absence(site: Path) -> None:
    install_plugin(site, "a-usurper", "x", TRANSPORT_PLUGIN.format(name="mqtt"))
    assert load(site).plugins[0].failure == "transport 'mqtt' is reserved for imu-mqtt"


def install_conversion(site: Path, distribution: str, create: str, msg_type: str = "Force") -> None:
    code = CONVERSION_PLUGIN.format(create=create, msg_type=msg_type)
    install_plugin(site, distribution, "force", code)


def test_a_conversion_is_made_only_when_its_backend_asks_for_it(site: Path) -> None:
    install_conversion(site, "arm", "return [7]")
    registry = load(site)
    (plugin,) = registry.plugins[0].descriptors
    assert (plugin.kind, plugin.name) == ("conversion", "arm_force.Force on ros2")
    force = sys.modules["arm_force"].Force
    assert registry.create_conversion(force, "ros2", lambda given: given[0]) == 7
    assert registry.create_conversion(force, "zenoh", lambda given: given[0]) is None
    assert registry.create_conversion(int, "ros2", lambda given: given[0]) is None


def test_a_conversion_that_fails_is_one_line_that_names_its_plugin(site: Path) -> None:
    install_conversion(site, "arm", "raise OSError('no\\nluck')")
    registry = load(site)
    with pytest.raises(PluginError) as caught:
        registry.create_conversion(sys.modules["arm_force"].Force, "ros2", print)
    assert str(caught.value) == (
        "conversion 'arm_force.Force on ros2' cannot be used: arm:force failed: OSError: no luck"
    )


def test_a_class_that_two_plugins_convert_is_converted_by_neither(site: Path) -> None:
    install_conversion(site, "arm", "return 1")
    install_conversion(site, "leg", "return 2", "__import__('arm_force').Force")
    registry = load(site)
    reason = "conversion 'arm_force.Force on ros2' is claimed by arm:force and leg:force"
    assert [record.failure for record in registry.plugins] == [reason, reason]
    with pytest.raises(PluginError, match=reason):
        registry.create_conversion(sys.modules["arm_force"].Force, "ros2", print)


def test_a_conversion_is_listed_without_being_made(
    site: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    install_conversion(site, "arm", "raise SystemExit")
    registry = load(site)
    monkeypatch.setattr("rosbase.cli.list_plugins.installed_plugins", lambda: registry)
    list_plugins(Namespace())
    assert capsys.readouterr().out == (
        "force  active  arm 1.2  conversion: arm_force.Force on ros2\n"
    )


@pytest.mark.parametrize(
    ("kind", "name", "line"),
    [
        (
            "transport",
            "mqtt",
            "transport 'mqtt' needs the package imu-mqtt;"
            " in a clone of rosbase: pip install ./packages/imu-mqtt;"
            " from an index that has it (PyPI does not yet): pip install imu-mqtt",
        ),
        (
            "transport",
            "serial",
            f"transport 'serial' needs the package imu-serial; {how_to_install('imu-serial')}",
        ),
        (
            "backend",
            "ros2",
            f"backend 'ros2' needs the package rosbase-ros2; {how_to_install('rosbase-ros2')}",
        ),
        (
            "command",
            "view",
            f"command 'view' needs the package rosbase-view; {how_to_install('rosbase-view')}",
        ),
        ("transport", "cam", "no transport 'cam'; installed: can; did you mean 'can'?"),
        ("preset", "x", "no preset 'x'; installed: none"),
    ],
)
def test_what_is_not_installed_is_explained(site: Path, kind: str, name: str, line: str) -> None:
    install_plugin(site, "a-good", "can", TRANSPORT_PLUGIN.format(name="can"))
    with pytest.raises(NotInstalledError) as caught:
        getattr(load(site), kind)(name)
    assert str(caught.value) == line


def test_a_package_that_is_there_but_broken_is_not_said_to_be_missing(site: Path) -> None:
    install_plugin(site, "imu-serial", "serial", "import no_such_library")
    with pytest.raises(NotInstalledError, match=r"imu-serial:serial failed: ModuleNotFoundError"):
        load(site).transport("serial")


def test_the_core_brings_its_backend_presets_and_commands() -> None:
    registry = installed_plugins()
    assert registry.backend("local").name == "local"
    assert {"ros", "waveshare_ugv", "mpu6050", "custom"} <= set(registry.presets)
    assert {"imu", "demo", "plugins"} <= set(registry.commands)
