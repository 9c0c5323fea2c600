"""The address of the page, and which requests may see it."""

import pytest

from rosbase import ConfigurationError
from rosbase_view.web.address import checked_token, inner_path, new_token, page_url

TOKEN = "secret-secret-16"


@pytest.mark.parametrize(
    ("path", "inner"),
    [
        (f"/{TOKEN}/", "/"),
        # viser's client connects without the last slash.
        (f"/{TOKEN}", "/"),
        (f"/{TOKEN}?initialCameraFov=1", "/"),
        (f"/{TOKEN}/assets/index.js", "/assets/index.js"),
        (f"/{TOKEN}/index.html?x=1", "/index.html"),
    ],
)
def test_a_path_with_the_token_is_served(path: str, inner: str) -> None:
    assert inner_path(path, TOKEN) == inner


@pytest.mark.parametrize(
    "path",
    [
        "/",
        "",
        "/index.html",
        f"/{TOKEN[:-1]}/",
        f"/{TOKEN}x/",
        f"/x/{TOKEN}/",
        f"//{TOKEN}/",
        f"/?{TOKEN}/",
        f"/{TOKEN.upper()}/",
        "/sécret/",
        "/\ud800/",
    ],
)
def test_a_path_without_the_token_is_refused(path: str) -> None:
    assert inner_path(path, TOKEN) is None


def test_each_view_has_a_token_of_its_own_that_can_stand_in_an_address() -> None:
    tokens = {new_token() for _ in range(100)}
    assert len(tokens) == 100
    assert all(checked_token(token, "TOKEN") == token for token in tokens)


@pytest.mark.parametrize(
    "token", ["", "short", "a" * 129, "with a blank in it", "a/b/c/d/e/f/g/h/i"]
)
def test_a_token_that_could_be_guessed_or_breaks_the_address_is_refused(token: str) -> None:
    with pytest.raises(ConfigurationError, match="TOKEN needs 16 to 128 characters"):
        checked_token(token, "TOKEN")


@pytest.mark.parametrize(
    ("host", "url"),
    [
        ("127.0.0.1", f"http://127.0.0.1:8080/{TOKEN}/"),
        ("::1", f"http://[::1]:8080/{TOKEN}/"),
        ("robot.local", f"http://robot.local:8080/{TOKEN}/"),
        ("0.0.0.0", f"http://quadruped:8080/{TOKEN}/"),
        ("::", f"http://quadruped:8080/{TOKEN}/"),
    ],
)
def test_the_address_can_be_opened(host: str, url: str) -> None:
    assert page_url(host, 8080, TOKEN, "quadruped") == url
