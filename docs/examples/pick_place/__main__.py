"""Pick and place: `python docs/examples/pick_place`."""

from argparse import ArgumentParser

from bridge import Bridge
from camera import Camera
from confirmer import Confirmer
from handlers import PickPlaceHandlers
from manager import PickPlaceRUN
from robot import SimulatedRobot
from tracker import Tracker

NODES = {"robot": SimulatedRobot, "camera": Camera, "bridge": Bridge, "tracker": Tracker}
AGENTS = {"confirmer": Confirmer}


def main() -> None:
    """Runs the task, or prints its diagram."""
    parser = ArgumentParser(prog="pick_place", description="Picks up a cup and puts it on a tray.")
    parser.add_argument("--diagram", action="store_true", help="print the task as Mermaid text")
    if parser.parse_args().diagram:
        print(PickPlaceHandlers().machine.to_mermaid(), end="")
        return
    manager = PickPlaceRUN(
        node_name="PickPlaceOrchestrator",
        nodes_dict=NODES,
        agents_dict=AGENTS,
        node_freq_hz=50,
        start_state="PREPARE",
    )
    manager.start_main_loop_timer()


if __name__ == "__main__":
    main()
