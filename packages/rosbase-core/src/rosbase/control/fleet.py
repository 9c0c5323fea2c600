"""The running programs of this user, for scripts and tests."""

from __future__ import annotations

from rosbase.control.questions.lifecycle import LifecycleQuestions
from rosbase.control.questions.parameters import ParameterQuestions
from rosbase.control.questions.programs import ProgramQuestions
from rosbase.control.questions.publishing import PublishQuestions
from rosbase.control.questions.services import ServiceQuestions

__all__ = ["Fleet"]


class Fleet(
    PublishQuestions, ServiceQuestions, ParameterQuestions, LifecycleQuestions, ProgramQuestions
):
    """The running programs of this user, or one of them; `rosbase.control.connect` returns it.

    Nothing is kept between two questions: any thread may ask, and each answer is of the programs
    that run at that time. A program that does not answer within a second is named on stderr, and
    left out for five seconds.
    """

    def __enter__(self) -> Fleet:
        return self

    def __exit__(self, *_: object) -> None:
        pass
