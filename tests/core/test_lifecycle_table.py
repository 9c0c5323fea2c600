"""The table against lifecycle_msgs and rcl, from which these literals are copied."""

from rosbase.lifecycle import CALLBACKS, TRANSITIONS, CallbackReturn, State, starting_at

RCL = """
1 configure unconfigured configuring
10 transition_success configuring inactive
11 transition_failure configuring unconfigured
12 transition_error configuring errorprocessing
2 cleanup inactive cleaningup
20 transition_success cleaningup unconfigured
21 transition_failure cleaningup inactive
22 transition_error cleaningup errorprocessing
3 activate inactive activating
30 transition_success activating active
31 transition_failure activating inactive
32 transition_error activating errorprocessing
4 deactivate active deactivating
40 transition_success deactivating inactive
41 transition_failure deactivating active
42 transition_error deactivating errorprocessing
5 shutdown unconfigured shuttingdown
6 shutdown inactive shuttingdown
7 shutdown active shuttingdown
50 transition_success shuttingdown finalized
51 transition_failure shuttingdown finalized
52 transition_error shuttingdown errorprocessing
60 transition_success errorprocessing unconfigured
61 transition_failure errorprocessing finalized
62 transition_error errorprocessing finalized
"""


def test_all_25_transitions_stand_in_rcl_order() -> None:
    ours = [f"{t.id} {t.label} {t.start.label} {t.goal.label}" for t in TRANSITIONS]
    assert ours == RCL.split("\n")[1:-1]


def test_all_11_states_have_the_ids_of_lifecycle_msgs() -> None:
    assert {state.label: state.id for state in State} == {
        "unknown": 0,
        "unconfigured": 1,
        "inactive": 2,
        "active": 3,
        "finalized": 4,
        "configuring": 10,
        "cleaningup": 11,
        "shuttingdown": 12,
        "activating": 13,
        "deactivating": 14,
        "errorprocessing": 15,
    }


def test_callback_returns_are_those_of_lifecycle_msgs() -> None:
    assert [(r.name, r.value) for r in CallbackReturn] == [
        ("SUCCESS", 97),
        ("FAILURE", 98),
        ("ERROR", 99),
    ]


def test_each_primary_state_exposes_what_rcl_exposes() -> None:
    exposed = {s.label: [t.id for t in starting_at(s)] for s in State if s.is_primary}
    assert exposed == {
        "unknown": [],
        "unconfigured": [1, 5],
        "inactive": [2, 3, 6],
        "active": [4, 7],
        "finalized": [],
    }


def test_each_transition_state_has_a_callback_and_all_three_ways_out() -> None:
    assert set(CALLBACKS) == {state for state in State if not state.is_primary}
    for state in CALLBACKS:
        assert [t.label for t in starting_at(state)] == [r.label for r in CallbackReturn]
