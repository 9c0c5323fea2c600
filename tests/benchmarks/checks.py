"""What the checks of a sample cost: CPU nanoseconds for each, at rest and on the move.

`nox -s bench -- checks` runs it and prints a table. The cheapest of many turns counts. The checks
that are on by default must stay well below a microsecond together.
"""

import time
from random import Random

from attrs import evolve

from rosbase.imu.checks.suite import Checks, CheckSettings
from rosbase.imu.mapping import ImuMapping, Sample
from rosbase.imu.motion import motion_at

TURNS, SAMPLES, PERIOD_NS = 31, 5_000, 10_000_000

OFF = CheckSettings(gravity="off", gravity_direction="off", frozen="off")
SETTINGS = {
    "all that are on by default": CheckSettings(),
    "gravity": evolve(OFF, gravity="warn"),
    "gravity_direction": evolve(OFF, gravity_direction="warn"),
    "frozen": evolve(OFF, frozen="warn"),
    "none": OFF,
}


def samples(*, at_rest: bool) -> list[Sample]:
    """Samples at 100 Hz, with the noise of a cheap sensor."""
    draw = Random(1)
    made = []
    for number in range(SAMPLES):
        motion = motion_at(0.0 if at_rest else number / 100)
        q, w, a = motion.orientation, motion.angular_velocity, motion.linear_acceleration
        rate = tuple(axis + draw.gauss(0.0, 0.002) for axis in (w.x, w.y, w.z))
        force = tuple(axis + draw.gauss(0.0, 0.02) for axis in (a.x, a.y, a.z))
        made.append(Sample((q.x, q.y, q.z, q.w), rate, force, None, None))
    return made


def cost_ns(settings: CheckSettings, stream: list[Sample]) -> float:
    """The CPU time of one sample."""
    best_ns = float("inf")
    for _ in range(TURNS):
        judge = Checks(settings, ImuMapping()).judge
        arrived_ns = 0
        begun_ns = time.process_time_ns()
        for sample in stream:
            arrived_ns += PERIOD_NS
            judge(sample, arrived_ns)
        best_ns = min(best_ns, (time.process_time_ns() - begun_ns) / len(stream))
    return best_ns


def main() -> None:
    """Prints the table."""
    streams = {"at rest": samples(at_rest=True), "moving": samples(at_rest=False)}
    print(f"{'ns CPU/sample':28}" + "".join(f"{name:>10}" for name in streams))
    for name, settings in SETTINGS.items():
        costs = (cost_ns(settings, stream) for stream in streams.values())
        print(f"{name:28}" + "".join(f"{cost:10.0f}" for cost in costs))


if __name__ == "__main__":
    main()
