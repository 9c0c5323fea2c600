"""The last message as a tree."""

from rosbase_view.message_tree import TreeRow, tree_rows
from support.viewing import imu


def texts(rows: list[TreeRow]) -> list[str]:
    return [f"{'  ' * row.depth}{row.name}: {row.value}".rstrip() for row in rows]


def test_an_imu_is_a_few_rows() -> None:
    assert texts(tree_rows(imu(0.0))) == [
        "header:",
        "  stamp: sec 12  nanosec 345000000",
        "  frame_id: imu_link",
        "orientation: x  0  y  0  z  0  w  1",
        "orientation_covariance: [ 0, 0, 0, 0, 0, 0, 0, 0, 0]",
        "angular_velocity: x  0.01  y -0.5  z  1.25",
        "angular_velocity_covariance: [ 0, 0, 0, 0, 0, 0, 0, 0, 0]",
        "linear_acceleration: x  0.3  y -0.1  z  9.80665",
        "linear_acceleration_covariance: [ 0, 0, 0, 0, 0, 0, 0, 0, 0]",
    ]


def test_what_is_folded_is_left_out_with_all_that_is_below() -> None:
    rows = tree_rows(imu(), {("header",)})
    assert rows[0] == TreeRow(("header",), "header", "", False)
    assert rows[1].name == "orientation"


def test_a_list_of_messages_has_a_row_for_each_and_its_length() -> None:
    message = {"status": ({"name": "a", "level": b"\x01"}, {"name": "b", "level": b"\x02"})}
    assert texts(tree_rows(message)) == [
        "status: [2]", "  0:", "    name: a", "    level: [ 1]", "  1:", "    name: b",
        "    level: [ 2]",
    ]  # fmt: skip


def test_a_long_list_is_cut_and_says_how_long_it_is() -> None:
    numbers = memoryview(bytes(range(100)))
    assert tree_rows({"data": numbers})[0].value == "[ 0, 1, 2, 3, 4, 5, 6, 7, 8 ... [100]]"
    assert len(tree_rows({"names": tuple("abcdefghij" * 10)})) == 21


def test_empty_lists_and_truth_are_told() -> None:
    message = {"none": (), "no_bytes": b"", "on": True}
    assert texts(tree_rows(message)) == ["none: []", "no_bytes: []", "on: True"]
