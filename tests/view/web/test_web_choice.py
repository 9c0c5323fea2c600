"""Drop-downs: what is offered, and what stays chosen."""

from rosbase_view.web.choice import Choice

PROGRAMS = {1: "/left", 2: "/right", 3: "/right"}


def choice_of(*keys: tuple[str, int]) -> Choice:
    found = Choice()
    found.offer(keys, PROGRAMS)
    return found


def test_nothing_can_be_chosen_from_nothing() -> None:
    choice = choice_of()
    assert (choice.key, choice.label, list(choice.labels)) == (None, "", [])


def test_the_first_is_chosen_until_the_user_chooses_another() -> None:
    choice = choice_of(("/b", 1), ("/a", 1))
    assert choice.label == "/a"
    choice.choose("/b")
    choice.offer([("/a", 1), ("/b", 1), ("/0", 1)], PROGRAMS)
    assert choice.key == ("/b", 1)


def test_what_is_chosen_stays_so_while_it_is_gone_and_comes_back_with_another_pid() -> None:
    choice = choice_of(("/a", 1), ("/b", 1))
    choice.choose("/b")
    choice.offer([("/a", 1)], PROGRAMS)
    assert (choice.key, choice.label) == (None, "/b (gone)")
    assert list(choice.labels) == ["/b (gone)", "/a"]
    choice.choose("/b (gone)")
    choice.offer([("/a", 1), ("/b", 2)], PROGRAMS)
    assert (choice.key, choice.label) == (("/b", 2), "/b")
    assert list(choice.labels) == ["/a", "/b"]


def test_two_of_one_name_are_told_apart_by_their_programs() -> None:
    choice = choice_of(("/a", 1), ("/a", 2))
    assert list(choice.labels) == ["/a (left)", "/a (right)"]
    choice.choose("/a (right)")
    assert choice.key == ("/a", 2)
    choice.offer([("/a", 2)], PROGRAMS)
    assert choice.label == "/a"
    choice.offer([("/a", 2), ("/a", 3), ("/a", 4)], PROGRAMS)
    assert list(choice.labels) == ["/a (right [2])", "/a (right [3])", "/a ([4])"]


def test_only_what_is_offered_can_be_chosen() -> None:
    choice = choice_of(("/a", 1))
    choice.choose("/b")
    choice.prefer(("/c", 1))
    assert choice.key == ("/a", 1)
