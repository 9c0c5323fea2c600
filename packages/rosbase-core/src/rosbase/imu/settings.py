"""The reader's parameters: what they are, and what their values together mean."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from attrs import frozen

from rosbase.errors import ParameterError
from rosbase.imu.covariance import covariance_of
from rosbase.imu.mapping import GROUPS, VECTORS, ImuMapping
from rosbase.imu.presets import DEFAULT_PRESET
from rosbase.messages import Covariance
from rosbase.parameters import ParameterKind, ParameterSpec, ParameterValue
from rosbase.plugins import PluginRegistry, TransportPlugin

__all__ = [
    "DEFAULT_TRANSPORT",
    "READER_PARAMETERS",
    "ReaderSettings",
    "read_settings",
    "reader_parameters",
]

DEFAULT_TRANSPORT = "serial"
"""What `comm_t` is where nothing else is said."""

_MAPPING = "mapping."


def _text(name: str, default: str, description: str, *choices: str) -> ParameterSpec:
    return ParameterSpec(name, default, description, choices=choices)


def _texts(name: str, description: str) -> ParameterSpec:
    return ParameterSpec(name, [], description, kind=ParameterKind.STRING_ARRAY)


def _stddev(quantity: str, unit: str) -> ParameterSpec:
    return ParameterSpec(
        f"{quantity}_stddev",
        [],
        f"standard deviation in {unit}: one number, or three for x, y, z; none: unknown",
        kind=ParameterKind.DOUBLE_ARRAY,
        minimum=0.0,
    )


def _mapping_parameters() -> Iterable[ParameterSpec]:
    yield _texts("mapping.select", "conditions that a payload must meet, such as T=1002")
    yield _texts("mapping.required", "quantities without which a sample is refused")
    for group in GROUPS:
        yield _texts(f"mapping.{group}.paths", f"where the components of the {group} are")
    for group in VECTORS:
        yield _text(f"mapping.{group}.unit", "", f"the unit of the {group}")
    yield _text("mapping.orientation.order", "", "order of the quaternion: xyzw or wxyz")
    yield _texts("mapping.time.paths", "where the time is: one path, or seconds and nanoseconds")
    yield _text("mapping.time.unit", "", "the unit of a lone time value: s, ms, us or ns")
    yield ParameterSpec(
        "mapping.numeric_strings",
        default=False,
        description="whether a text such as 1.5 is a number",
    )
    yield ParameterSpec(
        "mapping.quaternion_tolerance",
        0.05,
        "how far from 1 the norm of an orientation may be",
        minimum=0.0,
        maximum=1.0,
    )


READER_PARAMETERS: tuple[ParameterSpec, ...] = (
    _text("comm_t", DEFAULT_TRANSPORT, "the transport, by name"),
    _text("preset", DEFAULT_PRESET, "the payload of a known device, by name"),
    _text("frame_id", "imu_link", "the name of the sensor's frame"),
    _text("topic_namespace", "imu", "what the topics data, data_raw and mag stand under"),
    _text(
        "time_source",
        "arrival",
        "stamps: arrival of the first byte, or the device's date",
        "arrival",
        "device",
    ),
    ParameterSpec(
        "stale_timeout", 1.0, "seconds without data after which health is WARN", minimum=0.001
    ),
    _text(
        "plausibility",
        "warn",
        "what to do when gravity at rest is not 9.81 m/s^2",
        "warn",
        "reject",
        "off",
    ),
    _text(
        "autostart",
        "none",
        "how far the node is brought up by itself",
        "none",
        "configure",
        "activate",
    ),
    _stddev("orientation", "rad"),
    _stddev("angular_velocity", "rad/s"),
    _stddev("linear_acceleration", "m/s^2"),
    _stddev("magnetic_field", "T"),
    *_mapping_parameters(),
)
"""Those of every reader; transports add theirs."""


@frozen
class ReaderSettings:
    """What the parameters say, checked and ready to use."""

    transport: TransportPlugin
    transport_values: Mapping[str, ParameterValue]
    mapping: ImuMapping
    frame_id: str
    topic_namespace: str
    uses_device_time: bool
    stale_timeout_s: float
    plausibility: str
    covariances: Mapping[str, Covariance]
    """By quantity; for those that a sample has."""


def reader_parameters(registry: PluginRegistry) -> list[ParameterSpec]:
    """The parameters of a reader with the transports that are installed.

    Raises:
        ParameterError: Two plugins mean different things by one name.
    """
    specs = {spec.name: spec for spec in READER_PARAMETERS}
    for transport in registry.transports.values():
        for spec in transport.parameters:
            if specs.setdefault(spec.name, spec) != spec:
                raise ParameterError(
                    f"transport {transport.name} has another parameter {spec.name} than others"
                )
    return list(specs.values())


def read_settings(
    registry: PluginRegistry, value_of: Callable[[str], ParameterValue]
) -> ReaderSettings:
    """The settings that the values of the parameters amount to.

    Raises:
        ConfigurationError: They ask for what is not installed, or contradict each other.
    """
    get: Callable[[str], Any] = value_of
    transport = registry.transport(get("comm_t"))
    settings = ReaderSettings(
        transport=transport,
        transport_values={spec.name: get(spec.name) for spec in transport.parameters},
        mapping=_mapping(registry.preset(get("preset")).values, get),
        frame_id=get("frame_id"),
        topic_namespace=get("topic_namespace"),
        uses_device_time=get("time_source") == "device",
        stale_timeout_s=get("stale_timeout"),
        plausibility=get("plausibility"),
        covariances={
            group: covariance_of(f"{group}_stddev", get(f"{group}_stddev")) for group in GROUPS
        },
    )
    settings.mapping.compile(device_time=settings.uses_device_time)
    return settings


def _mapping(preset: Mapping[str, ParameterValue], get: Callable[[str], Any]) -> ImuMapping:
    """The preset, with what the parameters say in its place.

    A unit or an order is never inherited by other paths than those it was stated for.
    """
    given = {
        spec.name.removeprefix(_MAPPING): get(spec.name)
        for spec in READER_PARAMETERS
        if spec.name.startswith(_MAPPING) and get(spec.name) != spec.default
    }
    values: dict[str, Any] = dict(preset)
    for key in given:
        if key.endswith(".paths"):
            values.pop(key.replace(".paths", ".unit"), None)
            values.pop(key.replace(".paths", ".order"), None)
    values |= given
    fields: dict[str, Any] = {
        key.replace(".", "_"): tuple(value) if isinstance(value, list) else value
        for key, value in values.items()
    }
    return ImuMapping(**fields)
