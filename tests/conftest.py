"""What all tests share: hypothesis profiles, checked records, one browser, and a limit on skipped tests.

Hypothesis tries the same examples at every run in CI, and new ones elsewhere. Every record that the code under test
writes as JSON must follow the schema it names. There is one browser.
"""

import atexit
import gc
import os
import re
import shutil
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from tests.kept import folder_of_run, keep_in
from tests.lint.skips import unexpected_skips
from tests.record_checks import checked_to_json
from tests.running import kernel_work_here
from tests.whole import whole_differences
from wpcal.core import records
from wpcal.core.process import collect_rarely

# A shell's background job ignores Ctrl-C, and so would the commands that the tests start and interrupt.
signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile("ci", derandomize=True, deadline=None)
settings.register_profile("dev", deadline=None)
settings.load_profile("ci" if os.environ.get("CI") else "dev")

# Else every command that a test starts compiles the whole product anew, which takes longer than most commands.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# Nothing that collecting makes is garbage: it is looked through neither then nor while the tests run.
gc.disable()

# A slow machine does not make a command say more.
os.environ.setdefault("WPCAL_PROGRESS_AFTER_S", "600")

# Each test finds everything anew, unless it says otherwise (`answers`); those of the cache name a folder of their own.
os.environ["WPCAL_CACHE"] = "off"

# Set while conftest is imported, before any module under test takes the function by name: so no record goes unchecked.
records.to_json = checked_to_json

FLAGS = [
    "--headless=new",
    "--no-sandbox",  # tests run as root in containers
    "--use-angle=swiftshader",  # WebGL 2 without a graphics card
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",  # only WebGL is drawn by SwiftShader; the page around it costs half as much without
]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--assert-skips", action="store_true", help="fail when more tests are skipped than MOST_SKIPS allows"
    )
    parser.addoption("--regenerate", action="store_true", help="write the golden results anew; refused where CI is set")


def pytest_configure(config: pytest.Config) -> None:
    # In the order of their names: by the number of tests, files of one test that takes long would come last, alone.
    config.option.loadscopereorder = False
    if config.getoption("regenerate") and os.environ.get("CI"):
        raise pytest.UsageError("golden results are not regenerated where CI is set")


def pytest_collection_finish() -> None:
    gc.freeze()  # at its end, pytest looks through the garbage of the tests only
    atexit.register(gc.unfreeze)  # some extension modules complain of what they still hold when the process ends
    gc.enable()
    collect_rarely()


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if reporter is None or not session.config.getoption("--assert-skips"):
        return
    reasons = [report.longrepr[2].removeprefix("Skipped: ") for report in reporter.stats.get("skipped", [])]
    rows = unexpected_skips(reasons)
    if rows:
        reporter.write_line("")
        reporter.write_line("\n".join(rows), red=True)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Print what deep tests measured (property ``measured``), also of those that passed in another process."""
    reports = [*terminalreporter.stats.get("passed", []), *terminalreporter.stats.get("failed", [])]
    told = [
        f"{report.nodeid}: {value}"
        for report in reports
        for name, value in report.user_properties
        if name == "measured"
    ]
    if told:
        terminalreporter.section("measured")
        terminalreporter.write_line("\n".join(told))


@pytest.fixture(scope="session")
def answers(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What commands found in parts during this run, of all workers: a test is about what is done with it then.

    `test_answer_cache` has the law that a kept answer is a fresh one, byte for byte.
    """
    return folder_of_run(tmp_path_factory) / "answers"


@pytest.fixture(scope="session", autouse=True)
def _kept_in_run(tmp_path_factory: pytest.TempPathFactory) -> None:
    keep_in(folder_of_run(tmp_path_factory) / "kept")


@pytest.fixture(scope="module")
def kernel_here(answers: Path) -> Iterator[None]:
    """Let commands do their kernel work in this process, for tests in which its own process says no more.

    Starting that process and loading the kernel costs more than most commands, and so does finding the seams again.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cad.work.child.run_in_child", kernel_work_here)
        patch.setenv("WPCAL_CACHE", str(answers))
        yield


@pytest.fixture(scope="session")
def regenerate(request: pytest.FixtureRequest) -> bool:
    return bool(request.config.getoption("regenerate"))


@pytest.fixture
def golden(request: pytest.FixtureRequest, regenerate: bool) -> Callable[[Any], None]:
    """Compare a whole record with the golden one of the test."""

    def compare(value: Any) -> None:
        name = re.sub(r"[^\w-]+", "_", request.node.name.removeprefix("test_")).strip("_")
        folder = request.node.path.stem.removeprefix("test_")
        is_deep = request.node.get_closest_marker("deep") is not None  # these have no kept record
        told = [] if is_deep else whole_differences(f"{folder}/{name}", value, regenerate=regenerate)
        assert told == [], "if this change is meant: run the test with --regenerate"

    return compare


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Debian's chromium driven by playwright, one for all tests of a process; skipped where one of them is not here."""
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("chromium is not here; as root: sh .ci/browser")
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with playwright.sync_playwright() as driver:
        running = driver.chromium.launch(executable_path=chromium, args=FLAGS)
        yield running
        running.close()
