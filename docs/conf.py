"""How Sphinx makes the documentation site: `nox -s docs`. It needs no network."""

import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rosbase import installed_plugins

sys.path.insert(0, str(Path(__file__).parent))

from generators import (
    capabilities,
    conformance,
    demo,
    docstrings,
    facts,
    lifecycle,
    mermaid,
    names,
    public,
    reasons,
    roles,
    search,
    values,
    view,
    widths,
)

project = "rosbase"
author = "The rosbase authors"
project_copyright = author
html_title = "rosbase"
html_theme = "furo"
html_copy_source = False
html_show_sphinx = False
html_static_path = ["static"]
html_css_files = ["pages.css"]
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton"]
# What a tool leaves in a folder, such as the cache of pytest in an example, is no page. Patterns
# meet the paths of installed extensions too, so they begin with a folder of the documentation.
exclude_patterns = ["generators", "template", "examples/**/.*/**"]

# Markdown. Directives stand between colons, so that what stands between backticks is code to run.
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 3

# Docstrings: Google style; what stands in single backticks is code.
default_role = "code"
autodoc_default_options = {"members": True, "undoc-members": True}
autodoc_member_order = "bysource"
# Names are imported from `rosbase`, not from the modules that define them.
add_module_names = False
autodoc_typehints_format = "short"
autoclass_content = "both"
napoleon_numpy_docstring = False
python_use_unqualified_type_names = True

# Every name in a signature leads somewhere, but for those that others document.
nitpicky = True
nitpick_ignore_regex = [
    (
        r"py:.*",
        r"(_thread|abc|argparse|collections|contextlib|enum|logging|pathlib|random|threading)\..*",
    ),
    (r"py:class", r"hypothesis\..*"),
    # What only rosbase itself makes.
    (
        r"py:class",
        r"rosbase\.(local|wire\.structure|plugins\.discovery|plugins\.switches|processes\.launch)\..*",
    ),
    (r"py:class", r"rosbase\.roles\.construction\..*"),
    (r"py:class", r"Form|RecordingSink"),
    # The part of a manager that its components see.
    (r"py:class", r"rosbase\.roles\.context\.ManagerContext"),
    # The types of ROS, in the fields of messages.
    (r"py:.*", r"u?int\d+|float\d+|byte|char|w?string|Buffer|Fixed|AtMost"),
    # Types that stand for any.
    (r"py:.*", r"[\w.]+[a-z]T(_co|_contra)?"),
]

GENERATED: dict[str, Callable[[], str]] = {
    "capabilities": lambda: capabilities.tables(installed_plugins()),
    "conformance": conformance.tables,
    "demo": demo.pictures,
    "facts": facts.facts,
    "lifecycle diagram": lifecycle.diagram,
    "lifecycle table": lifecycle.table,
    "public names": public.tables,
    "reasons": reasons.reasons,
    "roles": roles.diagram,
    "view": view.picture,
}


def fill_in(app: Any, page: str, source: list[str]) -> None:
    """Fill in what a page asks for in a comment: generated text, or words for the search.

    Sphinx calls it with the text of each page.
    """
    source[0] = re.sub(r"<!-- generated: (.+?) -->", lambda match: GENERATED[match[1]](), source[0])
    source[0] = re.sub(r"<!-- search: (.+?) -->", lambda match: search.entries(match[1]), source[0])


def setup(app: Any) -> None:
    """Called by Sphinx."""
    app.connect("source-read", fill_in)
    app.connect("missing-reference", names.find_public)
    app.connect("env-check-consistency", names.complain_of_missing)
    app.connect("doctree-read", mermaid.replace)
    app.connect("doctree-read", values.shorten)
    app.connect("doctree-read", widths.replace)
    app.connect("autodoc-process-signature", widths.simplify_signature)
    # Before napoleon, which reads what is left.
    app.connect("autodoc-process-docstring", docstrings.prepare, priority=400)
