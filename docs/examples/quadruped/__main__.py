"""A quadruped: `python docs/examples/quadruped`."""

from argparse import ArgumentParser

from bridge import Bridge
from handlers import QuadrupedHandlers
from joystick import ScriptedJoystick
from legs import SimulatedLegs
from manager import QuadrupedManager
from planner import Planner

NODES = {"legs": SimulatedLegs, "joystick": ScriptedJoystick, "bridge": Bridge}
AGENTS = {"planner": Planner}


def main() -> None:
    """Runs the robot, or prints the diagram of its states."""
    parser = ArgumentParser(prog="quadruped", description="Walks, falls, gets up, walks on.")
    parser.add_argument("--diagram", action="store_true", help="print the states as Mermaid text")
    if parser.parse_args().diagram:
        print(QuadrupedHandlers().machine.to_mermaid(), end="")
        return
    manager = QuadrupedManager(
        node_name="Quadruped",
        nodes_dict=NODES,
        agents_dict=AGENTS,
        node_freq_hz=50,
        start_state="cold_start",
    )
    manager.start_main_loop_timer()


if __name__ == "__main__":
    main()
