"""Sphinx settings: `make docs` builds the pages and the reference, and every warning is an error."""

import csv
import io
import os
from functools import cache
from pathlib import Path
from textwrap import indent

import click
from docutils import nodes
from jinja2 import BaseLoader
from jinja2.sandbox import SandboxedEnvironment
from numpydoc import docscrape_sphinx
from sphinx.application import Sphinx
from sphinx.search.en import SearchEnglish
from sphinx.util.docutils import SphinxDirective
from sphinx_click.ext import NESTED_FULL, NESTED_NONE, ClickDirective

from wpcal.cli.main import wpcal
from wpcal.core.version import __version__
from wpcal.seam.rules import Rule

project = "wpcal"
author = "The wpcal developers"
copyright = "the wpcal developers; MIT licence"  # noqa: A001 (Sphinx reads this name)
version = release = __version__

extensions = [
    "myst_parser",  # the pages are Markdown, readable as they lie
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",  # one page per module of the library
    "numpydoc",
    "sphinx_click",
]
html_theme = "basic"
if "CI" not in os.environ:  # which asks for warnings alone: sources, and the tree on every page, take half of the time
    extensions.append("sphinx.ext.viewcode")
    html_theme = "furo"
html_static_path: list[str] = []
html_search_scorer = str(Path(__file__).with_name("search_order.js"))
exclude_patterns = ["_build", "_templates"]
templates_path = ["_templates"]
autosummary_generate = True

myst_heading_anchors = 3
# Links to files of the repository that are not pages (fixtures, scripts) are kept as they are.
myst_url_schemes = ["http", "https", "mailto"]

autodoc_member_order = "bysource"
autodoc_typehints = "signature"  # docstrings give shapes, units and frames; the annotation gives the type
numpydoc_show_class_members = False  # autodoc lists them already
smartquotes = False  # options are written with two hyphens


class CommandsOfWpcal(ClickDirective):
    """All commands under the headings of `wpcal --help`."""

    required_arguments = 0

    def run(self) -> list[nodes.section]:
        """Return a section for `wpcal`, and one for each heading."""
        self.env = self.state.document.settings.env
        context = click.Context(wpcal, info_name="wpcal")
        sections = self._generate_nodes("wpcal", wpcal, None, NESTED_NONE)
        for title, names in wpcal.by_section().items():
            section = nodes.section("", nodes.title(text=title), ids=[nodes.make_id(title)], names=[title.lower()])
            for name in names:
                section.extend(self._generate_nodes(name, wpcal.get_command(context, name), context, NESTED_FULL))
            sections.append(section)
        return sections


class RulesOfSeams(SphinxDirective):
    """Every finding that speaks against a candidate, as `wpcal.seam.rules` has it."""

    def run(self) -> list[nodes.Node]:
        """Return the table, the strongest finding first."""
        text = io.StringIO()
        rows = (rule.value for rule in Rule)
        csv.writer(text).writerows((row.finding, f"{row.factor:g}", row.why, row.evidence) for row in rows)
        head = ".. csv-table::\n   :header: finding, factor, why, found by\n   :widths: 36, 8, 34, 22\n\n"
        return self.parse_text_to_nodes(head + indent(text.getvalue().replace("`", "``"), "   "))


OF_QUESTIONS = frozenset({
    "all", "can", "do", "does", "from", "have", "how", "i", "many", "much", "my", "need", "one", "what", "when",
    "where", "which", "who", "why", "you", "your",
})  # fmt: skip


class SearchQuestions(SearchEnglish):
    """English, without the words that make a question of a topic: a page has to hold all others."""

    stopwords = SearchEnglish.stopwords | OF_QUESTIONS

    @cache  # noqa: B019 (one object in the life of the process)
    def stem(self, word: str) -> str:
        """Return the stem of a word, which is looked for once: pages repeat their words."""
        return super().stem(word)


_environments: dict[str, SandboxedEnvironment] = {}


def _one_environment(loader: BaseLoader) -> SandboxedEnvironment:
    """Return the same templates for all docstrings: numpydoc compiles its own anew for each, a fifth of the build."""
    return _environments.setdefault("one", SandboxedEnvironment(loader=loader))


docscrape_sphinx.SandboxedEnvironment = _one_environment


def setup(app: Sphinx) -> None:
    """Add the directives of the commands and of the rules, and what the search asks for."""
    app.add_search_language(SearchQuestions)
    app.add_directive("commands-of-wpcal", CommandsOfWpcal)
    app.add_directive("rules-of-seams", RulesOfSeams)
