"""The site, built once for all tests of a run."""

import fcntl
import os
import subprocess
import sys
from pathlib import Path

import pytest

from support.code_blocks import ROOT

BUILT = "DOCS_SITE"
"""The environment variable that names a site that is built already, as `nox -s docs` does."""


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the built site. Of several workers, the first one builds it."""
    if BUILT in os.environ:
        return Path(os.environ[BUILT])
    own = tmp_path_factory.getbasetemp()
    folder = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    with (folder / "site.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "site" / "searchindex.js").exists():
            _build(folder)
    return folder / "site"


def _build(folder: Path) -> None:
    options = ["-q", "-n", "-W", "--keep-going", "-d", str(folder / "pages")]
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *options, str(ROOT / "docs"), str(folder / "site")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
