"""Explain why frames are refused: by the cause if it shows, else by the known reason."""

from collections.abc import Mapping

from rosbase.imu.diagnosis.cause import Cause
from rosbase.imu.diagnosis.frame import diagnose_frame
from rosbase.imu.diagnosis.payload import Mapped, diagnose_payload
from rosbase.imu.rejects import IGNORED, meaning_of
from rosbase.mapping.decoding import REPEATED, decode_payload
from rosbase.mapping.rejects import Reject

__all__ = ["Explanations"]

_OF_FRAMES = frozenset({"bad_json", "not_data", "not_utf8"})
_OF_PAYLOADS = frozenset({"incomplete", "missing_group", "no_imu_data", "wrong_type"})


class Explanations:
    """Explains refusals. It examines a frame only when it will be logged."""

    def __init__(self, hints: Mapping[str, str], mapped: Mapped) -> None:
        """Start without a frame.

        Args:
            hints: Hints of the transport, by reason.
            mapped: Places in which the mapping looks for each quantity.
        """
        self._hints = hints
        self._mapped = mapped
        self._causes: dict[str, str] = {}

    def explain(self, reject: Reject, frame: bytes) -> Cause:
        """Examine a refused frame; return why it was refused, in half a line."""
        cause = self._look(reject, frame)
        self._causes[reject.reason] = cause.text if cause else ""
        if cause is not None:
            return cause
        hint = self._hints.get(reject.reason)
        detail = f"{reject.detail}; {hint}" if reject.detail and hint else reject.detail
        return Cause(detail or self.of(reject.reason), reject.reason in IGNORED)

    def of(self, reason: str) -> str:
        """Return the meaning of a reason: the cause in the last examined frame, if it showed."""
        said = self._causes.get(reason)
        if said:
            return said
        return "; ".join(filter(None, (meaning_of(reason), self._hints.get(reason))))

    def _look(self, reject: Reject, frame: bytes) -> Cause | None:
        if reject.reason == "bad_json" and reject.detail.startswith(REPEATED):
            # Valid as far as syntax goes, so there is nothing else to find in it.
            return Cause(reject.detail)
        if reject.reason in _OF_FRAMES:
            return diagnose_frame(frame)
        if reject.reason in _OF_PAYLOADS:
            payload = decode_payload(frame)
            return diagnose_payload(payload, reject, self._mapped)
        return None
