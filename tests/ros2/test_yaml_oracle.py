"""YAML as `topic echo` and `param dump` write it, beside PyYAML, which the tools of ROS use."""

import sys
from typing import Any

import yaml
from hypothesis import given
from hypothesis import strategies as st

from rosbase.text.yaml_text import as_yaml
from support.strategies import YAML_DATA, YAML_KEYS


@given(
    st.dictionaries(YAML_KEYS, YAML_DATA, max_size=3) | st.lists(YAML_DATA, max_size=3),
    st.booleans(),
)
def test_it_is_what_pyyaml_writes(data: Any, sort_keys: bool) -> None:
    written = yaml.dump(
        data, allow_unicode=True, width=sys.maxsize, default_flow_style=False, sort_keys=sort_keys
    )
    assert as_yaml(data, sort_keys=sort_keys) == written


@given(st.dictionaries(YAML_KEYS, YAML_DATA, max_size=3))
def test_in_one_line_it_is_what_pyyaml_reads(data: Any) -> None:
    text = as_yaml(data, flow=True)
    assert text.count("\n") == 1
    assert repr(yaml.safe_load(text)) == repr(data)
