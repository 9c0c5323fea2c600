"""The compiled readers give what the language says that they give, for any mapping and payload."""

import json
import os
from collections import Counter
from random import Random
from typing import Any

from hypothesis import event, given
from hypothesis import strategies as st

from rosbase.errors import MappingError
from rosbase.imu.mapping import ImuMapping, Sample, SampleReader
from rosbase.mapping.assembly import Batch
from rosbase.mapping.rejects import Reject
from support.mapping_cases import Case, make_cases
from support.mapping_oracle import GROUPS, Outcome, read

# Read now, because a test does not see them. `nox -s million` sets the first.
SEED = int(os.environ.get("ROSBASE_MAPPING_SEED", "0"))
CASES = int(os.environ.get("ROSBASE_MAPPING_CASES", "1500"))


def simplify(found: Sample | Reject | Batch[Sample]) -> Any:
    """What a reader gives, as the oracle says it."""
    if isinstance(found, Reject):
        return found.reason
    if isinstance(found, Batch):
        return [simplify(sample) for sample in found.samples], found.interval_ns
    groups = {name: getattr(found, name) for name in GROUPS if getattr(found, name) is not None}
    return Outcome(groups, found.device_time_ns, [reject.reason for reject in found.left_out])


def compiled(case: Case) -> SampleReader | None:
    try:
        return ImuMapping(**case.fields).compile(device_time=case.device_time)
    except MappingError:
        return None


def check(case: Case, reader: SampleReader) -> Any:
    found = simplify(reader(json.dumps(case.payload).encode()))
    expected = read(case.fields, case.payload, device_time=case.device_time)
    assert found == expected, case
    return found


def kind(found: Any) -> str:
    if isinstance(found, str):
        return found
    return "several" if isinstance(found[0], list) else "part" if found.left_out else "sample"


@given(st.randoms(use_true_random=False))
def test_any_mapping_reads_any_payload_as_the_language_says(rng: Random) -> None:
    cases = make_cases(rng, 3)
    reader = compiled(cases[0])
    for case in cases:
        event("refused" if reader is None else kind(check(case, reader)))


def test_very_many_mappings_and_payloads() -> None:
    """A million of them with `nox -s million`."""
    seen: Counter[str] = Counter()
    seed = SEED
    while seen.total() - seen["refused"] < CASES:
        seed += 1
        cases = make_cases(Random(seed), 10)
        reader = compiled(cases[0])
        for case in cases:
            seen["refused" if reader is None else kind(check(case, reader))] += 1
    print(dict(seen))
    assert min(seen[fate] for fate in ("sample", "part", "several", "incomplete", "surplus")) > 0
