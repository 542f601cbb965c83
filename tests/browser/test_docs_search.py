"""The search of the documentation finds the page that answers a question, in the words of the person who asks."""

import subprocess
import sys
from pathlib import Path
from typing import Any
from urllib.parse import quote_plus

import pytest

DOCS = Path(__file__).parents[2] / "docs"
ANSWERS = {
    "my seam is missing": "seams.html",
    "which torch do you assume": "torches.html",
    "UNSURE what now": "how-to/fail-what-now.html",
    "plate is not where the model has it": "how-to/parts-that-moved.html",
    "how many points do I need": "how-to/choose-points.html",
    "robot moves through the part": "safety.html",
    "read points from my FANUC": "how-to/fanuc.html",
    "print a weld list": "how-to/teach-sheet.html",
    "one command for all parts of a day": "how-to/batch.html",
    "same result as last year": "how-to/batch.html",
}


@pytest.mark.deep
def test_the_first_page_found_answers_the_question(browser: Any, tmp_path: Path) -> None:
    command = ["env", "-u", "CI", sys.executable, "-m", "sphinx", "-q", "-b", "html", DOCS, tmp_path / "html"]
    subprocess.run(command, check=True, timeout=600, capture_output=True)
    page, found = browser.new_page(), {}
    for question in ANSWERS:
        page.goto(f"{(tmp_path / 'html' / 'search.html').as_uri()}?q={quote_plus(question)}")
        page.wait_for_selector("#search-results li a", timeout=60_000)
        page.wait_for_timeout(1000)  # headings are sorted in when all words are looked up
        found[question] = page.locator("#search-results li > a").first.get_attribute("href").split("?")[0].split("#")[0]
    page.close()
    assert found == ANSWERS
