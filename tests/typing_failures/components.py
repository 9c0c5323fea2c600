"""A component that is found by its class has the type of its class."""

from rosbase import BaseAgent, BaseHandlers, BaseManager, BaseNode


class Camera(BaseNode):
    picture = ""

    def follow(self) -> None:
        self.manager.request_stop()  # fails: without a manager there is none
        self.request_stop()


class Lidar(BaseNode):
    range_m = 0.0

    def forget(self) -> None:
        self.latest = None  # fails: it hides a method


class Pilot(BaseAgent):
    def reset(self) -> None:
        self.goal = 1.0

    def speed(self, x: float) -> float:
        return self.goal - x


class Handlers(BaseHandlers):
    def handle(self) -> None:
        print(self.node(Camera, "front").picture)
        print(self.node(Camera).range_m)  # fails: a lidar has it
        lidar: Lidar = self.node(Camera)  # fails: a camera
        print(lidar, self.node(Pilot))  # fails: an agent
        print(self.agent(Camera))  # fails: a node
        print(self.node("camera"))  # fails: a name is no class
        print(self.agent(Pilot).speed("far"))  # fails: a number
        self.manager.request_end()  # fails: misspelt
        self.manager.loop_stats.tiks += 1  # fails: misspelt
        self.logger.inform("seen")  # fails: no such level
        self.logger.info("seen", one=True)  # fails: misspelt


manager = BaseManager("app", {"camera": Camera}, {"pilot": Pilot}, Handlers)
print(manager.node(Camera).picture, manager.agent(Pilot).goal)
print(manager.node(Lidar).picture)  # fails: a camera has it
BaseManager("app", {"camera": Pilot})  # fails: an agent
BaseManager("app", {"camera": "Camera"})  # fails: a name is no class
