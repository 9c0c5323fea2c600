"""The reader's parameters, and the settings made from their values."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from attrs import evolve, frozen

from rosbase.errors import NotInstalledError, ParameterError
from rosbase.imu.changes import with_change_time
from rosbase.imu.checks.parameters import (
    CHECK_PARAMETERS,
    checks_without_effect,
    read_check_settings,
)
from rosbase.imu.checks.suite import CheckSettings
from rosbase.imu.covariance import covariance_of
from rosbase.imu.mapping import FULL_SCALES, GROUPS, MAX_TOLERANCE, VECTORS, ImuMapping
from rosbase.imu.presets import DEFAULT_PRESET
from rosbase.mapping.description import LARGEST
from rosbase.messages import Covariance
from rosbase.parameters import ParameterKind, ParameterSpec, ParameterValue, check_value
from rosbase.plugins import PluginRecord, PluginRegistry, PresetPlugin, TransportPlugin

__all__ = [
    "AS_PRESET",
    "DEFAULT_TRANSPORT",
    "READER_PARAMETERS",
    "ReaderSettings",
    "judged_plugins",
    "read_settings",
    "reader_parameters",
]

DEFAULT_TRANSPORT = "serial"
"""Default of `comm_t`."""

AS_PRESET = "<preset>"
"""Value of a mapping parameter that leaves it to the preset."""

_MAPPING = "mapping."


def _text(name: str, default: str, description: str, *choices: str) -> ParameterSpec:
    return ParameterSpec(name, default, description, choices=choices)


def _preset_texts(name: str, description: str) -> ParameterSpec:
    return ParameterSpec(name, [AS_PRESET], description, kind=ParameterKind.STRING_ARRAY)


def _preset_text(name: str, description: str) -> ParameterSpec:
    return ParameterSpec(name, AS_PRESET, description)


def _stddev(quantity: str, unit: str) -> ParameterSpec:
    return ParameterSpec(
        f"{quantity}_stddev",
        [],
        f"standard deviation in {unit}: one number, or three for x, y, z; none: unknown",
        kind=ParameterKind.DOUBLE_ARRAY,
        minimum=0.0,
    )


def _full_scale(quantity: str, unit: str) -> ParameterSpec:
    return ParameterSpec(
        f"{quantity}_full_scale",
        FULL_SCALES[quantity],
        f"maximum of a component that the sensor can measure, in {unit}; more is out_of_range",
        minimum=0.0,
        maximum=LARGEST,
    )


def _mapping_parameters() -> Iterable[ParameterSpec]:
    yield _preset_texts("mapping.select", "conditions that a payload must meet, such as T=1002")
    yield _preset_texts("mapping.required", "quantities without which a sample is refused")
    for group in GROUPS:
        yield _preset_texts(f"mapping.{group}.paths", f"paths to the components of the {group}")
    for group in VECTORS:
        yield _preset_text(f"mapping.{group}.unit", f"the unit of the {group}")
    yield _preset_text("mapping.orientation.order", "order of the quaternion: xyzw or wxyz")
    yield _preset_texts(
        "mapping.time.paths", "paths to the time: one, or two for seconds and nanoseconds"
    )
    yield _preset_text("mapping.time.unit", "the unit of a lone time value: s, ms, us or ns")
    yield _preset_text(
        "mapping.time.interval",
        "the time between the samples of one message, such as 5 ms, 200 Hz or rate Hz",
    )
    yield _preset_text(
        "mapping.absent", "meaning of a number that a payload leaves out: missing, or zero"
    )
    yield ParameterSpec(
        "mapping.numeric_strings",
        default=False,
        description="accept a text such as 1.5 as a number",
    )
    yield ParameterSpec(
        "mapping.sentinels",
        [],
        "numbers of the payload that mean no reading, such as -999; the quantity is then absent",
        kind=ParameterKind.DOUBLE_ARRAY,
    )
    yield ParameterSpec(
        "mapping.quaternion_tolerance",
        0.05,
        "maximum deviation of an orientation's norm from 1",
        minimum=0.0,
        maximum=MAX_TOLERANCE,
    )


READER_PARAMETERS: tuple[ParameterSpec, ...] = (
    _text("comm_t", DEFAULT_TRANSPORT, "the transport, by name"),
    _text("preset", DEFAULT_PRESET, "the payload of a known device, by name"),
    _text("frame_id", "imu_link", "the name of the sensor's frame"),
    _text("topic_namespace", "imu", "namespace of the topics data, data_raw and mag"),
    _text(
        "time_source",
        "arrival",
        "stamps: arrival of the first byte, or the device's date",
        "arrival",
        "device",
    ),
    ParameterSpec(
        "stale_timeout",
        1.0,
        "seconds without a sample after which the health is WARN",
        minimum=0.001,
    ),
    *CHECK_PARAMETERS,
    ParameterSpec(
        "autostart",
        "none",
        "how far the node goes by itself",
        choices=("none", "configure", "activate"),
        read_only=True,
    ),
    _stddev("orientation", "rad"),
    _stddev("angular_velocity", "rad/s"),
    _stddev("linear_acceleration", "m/s^2"),
    _stddev("magnetic_field", "T"),
    _full_scale("angular_velocity", "rad/s"),
    _full_scale("linear_acceleration", "m/s^2"),
    _full_scale("magnetic_field", "T"),
    *_mapping_parameters(),
)
"""Parameters of every reader; transports add theirs."""


_SPECS = {spec.name: spec for spec in READER_PARAMETERS}

_PRESETTABLE = {
    spec.name: spec
    for spec in READER_PARAMETERS
    if spec.name.startswith(_MAPPING) and spec.default in (AS_PRESET, [AS_PRESET])
}


@frozen
class ReaderSettings:
    """Settings from the parameters, checked and ready to use."""

    transport: TransportPlugin
    transport_values: Mapping[str, ParameterValue]
    mapping: ImuMapping
    frame_id: str
    topic_namespace: str
    uses_device_time: bool
    stale_timeout_s: float
    checks: CheckSettings
    covariances: Mapping[str, Covariance]
    """Covariance by quantity, for the quantities of a sample."""
    asked_for: tuple[str, ...] = ()
    """Quantities whose paths the user has given. A sample is published without them too."""
    without_effect: tuple[str, ...] = ()
    """User settings without effect, in a line each."""

    @property
    def device(self) -> str:
        """Device that is read: the value of the transport's first parameter."""
        return str(next(iter(self.transport_values.values()), self.transport.name))


def _clashes(registry: PluginRegistry) -> dict[str, str]:
    """Return transports that cannot be used, because their parameter has another meaning here.

    Returns:
        The reason, by the name of the transport. This project's own transports take precedence.

    Raises:
        PluginError: There is one, and `ROSBASE_STRICT_PLUGINS` is set.
    """
    owners = {spec.name: (spec, "the reader") for spec in READER_PARAMETERS}
    clashes: dict[str, str] = {}
    ordered = sorted(registry.transports, key=lambda name: not registry.is_ours("transport", name))
    for name in ordered:
        for spec in registry.transports[name].parameters:
            known, owner = owners.setdefault(spec.name, (spec, f"transport '{name}'"))
            if known != spec:
                clashes[name] = f"its parameter {spec.name} differs from that of {owner}"
    if clashes:
        registry.check_strictly(_failed_by(clashes, registry))
    return clashes


def judged_plugins(registry: PluginRegistry) -> list[PluginRecord]:
    """Return every plugin; a plugin has failed, too, if no reader can use its transport.

    Raises:
        PluginError: One has failed, and `ROSBASE_STRICT_PLUGINS` is set.
    """
    return _failed_by(_clashes(registry), registry)


def _failed_by(clashes: Mapping[str, str], registry: PluginRegistry) -> list[PluginRecord]:
    owners = {registry.owner_of(registry.transports[name]).full_name: name for name in clashes}
    return [
        evolve(record, failure=clashes[owners[record.full_name]])
        if record.full_name in owners
        else record
        for record in registry.plugins
    ]


def reader_parameters(registry: PluginRegistry) -> list[ParameterSpec]:
    """Return the parameters of a reader with the installed transports."""
    clashes = _clashes(registry)
    specs = {spec.name: spec for spec in READER_PARAMETERS}
    for name, transport in registry.transports.items():
        if name not in clashes:
            specs |= {spec.name: spec for spec in transport.parameters}
    return [with_change_time(spec) for spec in specs.values()]


def read_settings(
    registry: PluginRegistry, value_of: Callable[[str], ParameterValue]
) -> ReaderSettings:
    """Return the settings from the values of the parameters.

    Raises:
        ConfigurationError: They name something that is not installed, or contradict each other.
    """
    get: Callable[[str], Any] = value_of
    transport = registry.transport(get("comm_t"))
    clash = _clashes(registry).get(transport.name)
    if clash is not None:
        raise NotInstalledError(f"transport '{transport.name}' cannot be used: {clash}")
    settings = ReaderSettings(
        transport=transport,
        transport_values={spec.name: get(spec.name) for spec in transport.parameters},
        mapping=_mapping(registry.preset(get("preset")), get),
        frame_id=get("frame_id"),
        topic_namespace=get("topic_namespace"),
        uses_device_time=get("time_source") == "device",
        stale_timeout_s=get("stale_timeout"),
        checks=read_check_settings(get),
        covariances={
            group: covariance_of(f"{group}_stddev", get(f"{group}_stddev")) for group in GROUPS
        },
    )
    settings.mapping.compile(device_time=settings.uses_device_time)
    return evolve(
        settings,
        asked_for=tuple(
            group
            for group in GROUPS
            if _is_given(f"{_MAPPING}{group}.paths", get) and group not in settings.mapping.required
        ),
        without_effect=(*_without_effect(settings, get), *_of_others(settings, registry, get)),
    )


def _of_others(
    settings: ReaderSettings, registry: PluginRegistry, get: Callable[[str], Any]
) -> Iterable[str]:
    """Return user settings for a transport that is not the chosen one."""
    others = {
        spec.name: spec
        for name, transport in registry.transports.items()
        if name not in _clashes(registry)
        for spec in transport.parameters
    }
    for name, spec in others.items():
        if name not in settings.transport_values and get(name) != spec.default:
            yield f"{name} has no effect: comm_t is {settings.transport.name}"


def _without_effect(settings: ReaderSettings, get: Callable[[str], Any]) -> Iterable[str]:
    """Return user settings that have no effect."""
    for group in GROUPS:
        if getattr(settings.mapping, f"{group}_paths"):
            continue
        for kind in ("stddev", "full_scale"):
            spec = _SPECS.get(f"{group}_{kind}")
            if spec is not None and get(spec.name) != spec.default:
                yield f"{spec.name} has no effect: mapping.{group}.paths is empty"
    tolerance = _SPECS["mapping.quaternion_tolerance"]
    if not settings.mapping.orientation_paths and get(tolerance.name) != tolerance.default:
        yield f"{tolerance.name} has no effect: mapping.orientation.paths is empty"
    if not settings.uses_device_time and _is_given("mapping.time.paths", get):
        yield "mapping.time.paths has no effect: time_source is arrival"
    yield from checks_without_effect(
        get,
        uses_device_time=settings.uses_device_time,
        has_orientation=bool(settings.mapping.orientation_paths),
        has_acceleration=bool(settings.mapping.linear_acceleration_paths),
    )


def _is_given(name: str, get: Callable[[str], Any]) -> bool:
    return get(name) not in (AS_PRESET, [AS_PRESET], [], "")


def _mapping(preset: PresetPlugin, get: Callable[[str], Any]) -> ImuMapping:
    """Return the preset, with the changes from the parameters.

    Only the paths for which a unit or an order was stated use it; others never inherit it.
    """
    values = _preset_values(preset)
    given = {name: get(name) for name in _PRESETTABLE if get(name) not in (AS_PRESET, [AS_PRESET])}
    for name, value in given.items():
        if isinstance(value, list) and AS_PRESET in value:
            raise ParameterError(f"parameter {name}: {AS_PRESET} must be the only element")
        if name.endswith(".paths"):
            values.pop(name.replace(".paths", ".unit"), None)
            values.pop(name.replace(".paths", ".order"), None)
    values |= given
    fields: dict[str, Any] = {
        name.removeprefix(_MAPPING).replace(".", "_"): tuple(v) if isinstance(v, list) else v
        for name, v in values.items()
    }
    return ImuMapping(
        numeric_strings=get("mapping.numeric_strings"),
        sentinels=tuple(get("mapping.sentinels")),
        quaternion_tolerance=get("mapping.quaternion_tolerance"),
        **{f"{group}_full_scale": get(f"{group}_full_scale") for group in VECTORS},
        **fields,
    )


def _preset_values(preset: PresetPlugin) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for key, value in preset.values.items():
        spec = _PRESETTABLE.get(f"{_MAPPING}{key}")
        if spec is None:
            raise ParameterError(f"preset '{preset.name}' is broken: nothing is called {key!r}")
        values[spec.name] = check_value(spec, value)
    return values
