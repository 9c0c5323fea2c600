"""Answer requests about the recording that a program makes of itself."""

from typing import TYPE_CHECKING

from rosbase.control.programs import running_programs
from rosbase.control.requests import Answerer, Reply, Request
from rosbase.errors import ControlError, RecordingError
from rosbase.runtime.signal_masks import background_thread

if TYPE_CHECKING:
    from rosbase.control.session import Session

__all__ = ["ANSWERS"]


def _save(session: "Session", request: Request) -> Reply:
    """Write what the program keeps in memory, on a thread of its own: a disk may be slow."""
    found = [program.recording for program in running_programs()]
    recordings = [recording for recording in found if recording is not None]
    if not recordings:
        raise ControlError("this program does not record itself", "refused")

    def save() -> None:
        try:
            files = [recording.save() for recording in recordings]
        except RecordingError as error:
            request.fail(ControlError(str(error)))
            return
        paths = [str(file.resolve()) for file in files if file is not None]
        if paths:
            request.answer({"files": paths})
        else:
            text = "this program keeps nothing in memory: its recording goes to the disk"
            request.fail(ControlError(text, "refused"))

    background_thread(save, "recording.save").start()
    return request.wait()


ANSWERS: dict[str, Answerer] = {"recording.save": _save}
