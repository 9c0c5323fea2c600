"""Quality of service as `ros2 bag` writes it beside a topic. Pure.

A recording has the profiles in the metadata `offered_qos_profiles` of a channel, as YAML. With the
numbers of rmw, every distribution of ROS 2 reads it.
"""

from collections.abc import Iterable

from rosbase import QoSProfile

__all__ = ["profiles_text"]

# A duration without an end, as rmw has it.
_FOREVER = "\n    sec: 9223372036\n    nsec: 854775807"
_AUTOMATIC = 1
_KEEP_ALL = 2


def profiles_text(profiles: Iterable[QoSProfile]) -> str:
    """Return the profiles that the publishers of a topic offer; each once."""
    found = dict.fromkeys(_one(profile) for profile in profiles)
    return "\n".join(found)


def _one(profile: QoSProfile) -> str:
    # To keep all has no depth, whatever the profile says.
    depth = 0 if profile.history.value == _KEEP_ALL else profile.depth
    lines = (
        f"- history: {profile.history.value}",
        f"depth: {depth}",
        f"reliability: {profile.reliability.value}",
        f"durability: {profile.durability.value}",
        f"deadline:{_FOREVER}",
        f"lifespan:{_FOREVER}",
        f"liveliness: {_AUTOMATIC}",
        f"liveliness_lease_duration:{_FOREVER}",
        "avoid_ros_namespace_conventions: false",
    )
    return "\n  ".join(lines)
