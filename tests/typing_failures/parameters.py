"""The default of a parameter says the type of its value."""

from typing import Any

from rosbase import BaseManager, BaseNode, Parameter


class Camera(BaseNode):
    def __init__(self, manager: BaseManager | None = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.fps: int = self.declare_parameter("fps", 30).value
        self.gains: list[float] = self.declare_parameter("gains", [1.0, 2.0]).value
        self.name_of: str = self.declare_parameter("camera", "front").value
        self.rate: str = self.declare_parameter("rate", 30).value  # fails: a whole number
        self.limit: int = self.declare_parameter("limit", 0.5).value  # fails: a number
        self.declare_parameter("joints", {"hip": 1})  # fails: no type of a parameter
        self.declare_parameter("size", None)  # fails: no type of a parameter
        print(Parameter("fps", object()))  # fails: no type of a parameter
        self.set_parameters({"fps": 5})  # fails: a list of parameters

    def scale(self, parameter: Parameter[int]) -> str:
        return parameter.value  # fails: a whole number
