"""A topic has one class of messages, and a message has certain attributes."""

from typing import Any

from rosbase import BaseManager, BaseNode, Latest, LifecycleNode, Publisher, Subscription
from rosbase.messages import Imu, Point, Vector3


class Sensor(BaseNode):
    def __init__(self, manager: BaseManager | None = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.sender = self.create_publisher(Imu, "imu/data")
        self.imu = self.latest(Imu, "imu/data")
        self.create_subscription(Imu, "imu/data", self.keep)
        self.create_subscription(Point, "position", self.keep)  # fails: a callback for Imu
        self.create_subscription(Imu, "imu/data", lambda message: print(message.x))  # fails: no x
        self.points: Publisher[Point] = self.sender  # fails: a publisher of Imu
        self.heard: Subscription[Point] = self.create_subscription(Imu, "i", print)  # fails: of Imu
        self.position: Latest[Point] = self.latest(Imu, "imu/data")  # fails: the latest Imu

    def keep(self, message: Imu) -> None:
        print(message.linear_acceleration.z)
        print(message.linear_aceleration.z)  # fails: misspelt
        self.sender.publish(message)
        self.sender.publish(Point())  # fails: another class
        self.sender.publish(Imu)  # fails: the class, not a message
        message.angular_velocity = Vector3()  # fails: messages do not change

    def look(self) -> None:
        print(self.imu.value.header)  # fails: there may be no message yet
        if self.imu.value is not None:
            print(self.imu.value.header.stamp)
        print(self.imu.is_fresh("1 s"))  # fails: seconds are a number


class Driver(LifecycleNode):
    def __init__(self, manager: BaseManager | None = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.sender = self.create_publisher(Imu, "imu/data")

    def send(self) -> None:
        self.sender.publish(Imu())
        self.sender.publish(Point())  # fails: another class
