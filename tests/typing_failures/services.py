"""A service has one type of requests and one of answers."""

from attrs import frozen

from rosbase import BaseNode
from rosbase.messages import String


class Grasp:
    @frozen
    class Request:
        force: float = 0.0

    @frozen
    class Response:
        is_holding: bool = False


class NoType:
    Request = 5


class Gripper(BaseNode):
    def begin(self) -> None:
        self.create_service(Grasp, "a", self.grasp)
        self.create_service(Grasp, "b", self.grasp_as_in_rclpy)
        self.create_service(Grasp, "c", self.say)  # fails: it takes no request
        self.create_service(NoType, "e", self.grasp)  # fails: no type of a service
        client = self.create_client(Grasp, "a")
        client.call(Grasp.Request(4.5), timeout_s=1.0).is_holding.bit_length()
        client.call(String("open"))  # fails: no request
        client.call(Grasp.Request()).force  # fails: an answer has no force  # noqa: B018
        client.call(Grasp.Request(), timeout_s="1")  # fails: seconds are a number
        client.call_async(Grasp.Request()).result().is_holding.bit_length()
        client.call_async(Grasp.Request()).result().force  # fails: likewise  # noqa: B018

    def grasp(self, request: Grasp.Request) -> Grasp.Response:
        return Grasp.Response(request.force > 1.0)

    def grasp_as_in_rclpy(self, request: Grasp.Request, response: Grasp.Response) -> Grasp.Response:
        return response

    def say(self, message: String) -> Grasp.Response:
        return Grasp.Response()
