"""Sphinx settings: `make docs` builds the pages and the reference, and every warning is an error."""

from wpcal import __version__

project = "wpcal"
author = "The wpcal developers"
copyright = "the wpcal developers; MIT licence"  # noqa: A001 (Sphinx reads this name)
version = release = __version__

extensions = [
    "myst_parser",  # the pages are Markdown, readable as they lie
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx.ext.viewcode",
    "sphinx_click",
]
html_theme = "furo"
html_static_path: list[str] = []
exclude_patterns = ["_build"]

myst_heading_anchors = 3
# Links to files of the repository that are not pages (fixtures, scripts) are kept as they are.
myst_url_schemes = ["http", "https", "mailto"]

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the numpydoc sections give types with shapes, units and frames
numpydoc_show_class_members = False  # autodoc lists them already
smartquotes = False  # options are written with two hyphens
