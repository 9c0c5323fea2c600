"""The board in 3-D, on viser: x forward, y to the left, z up (REP-103)."""

import viser

from rosbase_view.web.quantities import Rotation

__all__ = ["Scene"]

_PCB = (30, 120, 60)
_UNKNOWN = (150, 150, 150)
_CHIP = (35, 35, 40)
_PIN = (212, 175, 55)
_LEVEL: Rotation = (1.0, 0.0, 0.0, 0.0)
_FLOOR = -0.6


class Scene:
    """A board over a floor, with the axes of its sensor and of the world."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Put everything into the scene."""
        scene = server.scene
        scene.set_up_direction("+z")
        server.initial_camera.position = (-1.25, -0.95, 0.85)
        server.initial_camera.look_at = (0.1, -0.25, -0.05)
        scene.add_grid("/floor", width=8.0, height=8.0, position=(0.0, 0.0, _FLOOR))
        self._add_world(scene)
        self._board = scene.add_frame("/board", axes_length=0.55, axes_radius=0.012)
        self._pcb = scene.add_box("/board/pcb", _PCB, (0.8, 0.5, 0.04))
        scene.add_box("/board/chip", _CHIP, (0.16, 0.16, 0.05), position=(0.05, 0.0, 0.04))
        # Pins at the back edge show where the front is.
        for number in range(6):
            position = (-0.36, 0.2 - 0.08 * number, 0.04)
            scene.add_box(f"/board/pin{number}", _PIN, (0.03, 0.03, 0.07), position=position)
        for name, place in (("x", (0.6, 0, 0)), ("y", (0, 0.6, 0)), ("z", (0, 0, 0.6))):
            scene.add_label(f"/board/{name}", name, position=place, anchor="center-center")

    def show(self, rotation: Rotation | None) -> None:
        """Turn the board; without an orientation it is grey, and turned as before."""
        if rotation is not None:
            self._board.wxyz = rotation
        colour = _UNKNOWN if rotation is None else _PCB
        if self._pcb.color != colour:
            self._pcb.color = colour

    def level(self) -> None:
        """Turn the board as it lies on the floor, for another board that is still unknown."""
        self._board.wxyz = _LEVEL

    @staticmethod
    def _add_world(scene: viser.SceneApi) -> None:
        """Add the axes of the world, which is ENU: yaw 0 is east (REP-103)."""
        corner = (-0.55, 0.2, _FLOOR)
        scene.add_frame("/world", axes_length=0.3, axes_radius=0.008, position=corner)
        names = (("x east", (0.36, 0, 0)), ("y north", (0, 0.36, 0)), ("z up", (0, 0, 0.36)))
        for name, place in names:
            scene.add_label(f"/world/{name}", name, position=place, anchor="center-center")
