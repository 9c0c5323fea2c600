"""Where the sockets of a user's programs are, and that the folder is this user's alone."""

import os
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosbase import ControlError
from rosbase.control import folder
from rosbase.control.folder import MOST_PATH, folders_to_read, make_folder, sockets

UID = os.geteuid()


@pytest.fixture
def short() -> Iterator[Path]:
    """A folder with a short path, of this user alone."""
    with tempfile.TemporaryDirectory(prefix="rb-") as made:
        yield Path(made)


@pytest.fixture
def places(short: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, Path]:
    """The runtime folder and the temporary one."""
    runtime, temporary = short / "run", short / "tmp"
    runtime.mkdir(0o700)
    temporary.mkdir()
    temporary.chmod(0o1777)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(runtime))
    monkeypatch.setattr(folder, "_TEMPORARY", str(temporary))
    return runtime, temporary


def mode(path: Path) -> int:
    return stat.S_IMODE(path.lstat().st_mode)


@pytest.fixture(params=[0o000, 0o022, 0o077])
def any_umask(request: pytest.FixtureRequest) -> Iterator[None]:
    before = os.umask(request.param)
    yield
    os.umask(before)


@pytest.mark.usefixtures("any_umask")
def test_the_folder_is_in_the_runtime_folder_with_rights_for_its_owner_only(
    places: tuple[Path, Path],
) -> None:
    made = places[0] / "rosbase"
    assert make_folder() == str(made)
    assert mode(made) == 0o700
    assert make_folder() == str(made)


def test_without_a_runtime_folder_it_is_in_the_temporary_one(
    places: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("XDG_RUNTIME_DIR")
    made = places[1] / f"rosbase-{UID}"
    assert make_folder() == str(made)
    assert mode(made) == 0o700


@pytest.mark.parametrize("given", ["", "relative", "/no/such/folder"])
def test_a_runtime_folder_that_is_none_does_not_count(
    places: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, given: str
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", given)
    assert make_folder() == str(places[1] / f"rosbase-{UID}")


def test_a_runtime_folder_in_which_others_may_write_does_not_count(
    places: tuple[Path, Path],
) -> None:
    places[0].chmod(0o1777)
    assert make_folder() == str(places[1] / f"rosbase-{UID}")


def test_the_runtime_folder_of_another_user_does_not_count(
    places: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    # As after `su`, which keeps the variable.
    monkeypatch.setattr("os.geteuid", lambda: UID + 1)
    with pytest.raises(ControlError, match=f"belongs to user {UID}"):
        make_folder()
    assert not (places[0] / "rosbase").exists()
    assert (places[1] / f"rosbase-{UID + 1}").exists()


def test_a_path_that_is_too_long_for_a_socket_does_not_count(
    places: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    long = places[0] / ("x" * 90)
    long.mkdir(0o700)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(long))
    assert make_folder() == str(places[1] / f"rosbase-{UID}")


def test_the_longest_path_that_is_used_fits_into_a_socket(
    places: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    room = MOST_PATH - len(f"{places[0]}//rosbase/1234567890-9.sock")
    fits, too_long = places[0] / ("x" * room), places[0] / ("x" * (room + 1))
    for path, used in ((fits, True), (too_long, False)):
        path.mkdir(0o700)
        monkeypatch.setenv("XDG_RUNTIME_DIR", str(path))
        assert (make_folder() == f"{path}/rosbase") is used


def test_a_link_in_its_place_is_refused(places: tuple[Path, Path]) -> None:
    elsewhere = places[0] / "elsewhere"
    elsewhere.mkdir(0o700)
    (places[0] / "rosbase").symlink_to(elsewhere)
    with pytest.raises(ControlError, match="is a symbolic link: remove it") as caught:
        make_folder()
    assert caught.value.kind == "refused"
    assert folders_to_read() == []


def test_a_file_in_its_place_is_refused(places: tuple[Path, Path]) -> None:
    (places[0] / "rosbase").touch()
    with pytest.raises(ControlError, match="is no directory"):
        make_folder()


@pytest.mark.parametrize("rights", [0o755, 0o750, 0o701, 0o770])
def test_a_folder_with_rights_for_others_is_refused(places: tuple[Path, Path], rights: int) -> None:
    made = places[0] / "rosbase"
    made.mkdir()
    made.chmod(rights)
    with pytest.raises(ControlError, match=f"run `chmod 700 {made}`"):
        make_folder()
    assert folders_to_read() == []
    made.chmod(0o700)
    assert make_folder() == str(made)


def test_the_folder_of_somebody_else_is_refused(
    places: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("XDG_RUNTIME_DIR")
    if UID == 0:
        made = places[1] / "rosbase-0"
        made.mkdir(0o700)
        os.chown(made, 65_534, 65_534)
        owner = 65_534
    else:
        monkeypatch.setattr("os.geteuid", lambda: UID + 1)
        owner = UID
    with pytest.raises(ControlError, match=f"belongs to user {owner}"):
        make_folder()


def test_a_temporary_folder_where_others_could_replace_it_is_refused(
    places: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("XDG_RUNTIME_DIR")
    places[1].chmod(0o777)
    with pytest.raises(ControlError, match=r"chmod \+t"):
        make_folder()


def test_a_folder_that_cannot_be_made_is_an_error_of_one_line(
    places: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("XDG_RUNTIME_DIR")
    monkeypatch.setattr(folder, "_TEMPORARY", "/proc/no/such")
    with pytest.raises(ControlError, match="cannot be made: No such file"):
        make_folder()


def test_programs_and_clients_with_different_temporary_folders_find_each_other(
    places: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("XDG_RUNTIME_DIR")
    monkeypatch.setenv("TMPDIR", str(places[0]))
    made = make_folder()
    monkeypatch.delenv("TMPDIR")
    assert made in folders_to_read()


def test_a_folder_that_the_environment_names_is_the_only_one(
    places: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    make_folder()
    own = places[0] / "own"
    monkeypatch.setenv("ROSBASE_CONTROL_FOLDER", f"{own}/")
    assert make_folder() == str(own)
    assert mode(own) == 0o700
    assert folders_to_read() == [str(own)]
    own.chmod(0o755)
    with pytest.raises(ControlError, match=f"run `chmod 700 {own}`"):
        make_folder()


def test_a_relative_folder_in_the_environment_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROSBASE_CONTROL_FOLDER", "run")
    for ask in (make_folder, sockets):
        with pytest.raises(ControlError, match="is an absolute path, not 'run'"):
            ask()


def test_clients_look_into_both_places(places: tuple[Path, Path]) -> None:
    paths = [places[0] / "rosbase", places[1] / f"rosbase-{UID}"]
    for number, path in enumerate(paths):
        path.mkdir(0o700)
        (path / f"{40 - number}.sock").touch()
    (paths[0] / "7-2.sock").touch()
    for name in ("x.sock", "9.sock.new", "9.txt", "-1.sock", ".sock", "notes"):
        (paths[0] / name).touch()
    assert sockets() == [
        (7, f"{paths[0]}/7-2.sock"),
        (39, f"{paths[1]}/39.sock"),
        (40, f"{paths[0]}/40.sock"),
    ]


def test_a_folder_with_wrong_rights_is_told_to_clients_unless_there_are_other_sockets(
    places: tuple[Path, Path],
) -> None:
    wrong, right = places[0] / "rosbase", places[1] / f"rosbase-{UID}"
    wrong.mkdir()
    wrong.chmod(0o755)
    (wrong / "7.sock").touch()
    with pytest.raises(ControlError, match=f"others may read {wrong}: run `chmod 700") as caught:
        sockets()
    assert caught.value.kind == "refused"
    # Otherwise anybody could end all commands of a user by a folder in /tmp.
    right.mkdir(0o700)
    (right / "8.sock").touch()
    assert sockets() == [(8, f"{right}/8.sock")]


def test_where_nothing_is_there_are_no_sockets(places: tuple[Path, Path]) -> None:
    assert places[0].exists()
    assert sockets() == []
    assert not (places[0] / "rosbase").exists()
