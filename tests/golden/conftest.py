import os

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--regenerate", action="store_true", help="write the golden results anew; refused where CI is set")


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("regenerate", default=False) and os.environ.get("CI"):
        raise pytest.UsageError("golden results are not regenerated where CI is set")


@pytest.fixture(scope="session")
def regenerate(request: pytest.FixtureRequest) -> bool:
    return bool(request.config.getoption("regenerate", default=False))
