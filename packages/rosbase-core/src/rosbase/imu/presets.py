"""The payloads of known devices, as data. The values go into the `mapping.*` parameters.

Sources are the firmwares themselves: their code shows which fields they print, and in which units.
Field names never tell a unit.
"""

from rosbase.plugins import PresetPlugin

__all__ = ["DEFAULT_PRESET", "PRESETS"]

DEFAULT_PRESET = "ros"


def _xyz(prefix: str) -> list[str]:
    return [f"{prefix}{axis}" for axis in "xyz"]


def _reported(quantity: str, axes: str = "xyz") -> list[str]:
    """Return the mapping of a quantity of sensor_msgs/Imu, unless its covariance excludes it."""
    return [f"[{quantity}_covariance[0]!=-1].{quantity}.{axis}" for axis in axes]


_INERTIAL = ["angular_velocity", "linear_acceleration"]

PRESETS: tuple[PresetPlugin, ...] = (
    PresetPlugin(
        "ros",
        "JSON shaped like sensor_msgs/Imu, SI units; orientation and header optional",
        {
            "orientation.paths": _reported("orientation", "xyzw"),
            "angular_velocity.paths": _reported("angular_velocity"),
            "angular_velocity.unit": "rad/s",
            "linear_acceleration.paths": _reported("linear_acceleration"),
            "linear_acceleration.unit": "m/s^2",
            "time.paths": [
                "header.stamp.sec|header.stamp.secs",
                "header.stamp.nanosec|header.stamp.nsecs",
            ],
            "required": _INERTIAL,
        },
    ),
    PresetPlugin(
        "waveshare_ugv",
        "Waveshare UGV rovers: lines tagged T=1002, with a magnetometer, no orientation",
        {
            "select": ["T=1002"],
            "angular_velocity.paths": _xyz("g"),
            "angular_velocity.unit": "rad/s",
            "linear_acceleration.paths": _xyz("a"),
            "linear_acceleration.unit": "m/s^2",
            "magnetic_field.paths": _xyz("m"),
            "magnetic_field.unit": "uT",
            "required": _INERTIAL,
        },
    ),
    PresetPlugin(
        "mpu6050",
        "MPU6050 sketches: accel_x .. gyro_z in m/s^2 and rad/s",
        {
            "angular_velocity.paths": _xyz("gyro_"),
            "angular_velocity.unit": "rad/s",
            "linear_acceleration.paths": _xyz("accel_"),
            "linear_acceleration.unit": "m/s^2",
            "required": _INERTIAL,
        },
    ),
    PresetPlugin("custom", "nothing but what the mapping.* parameters say", {}),
)
"""Presets of the core."""
