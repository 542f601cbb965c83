from __future__ import annotations

import sys
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
SHARED_STEP = HERE.parents[2] / "shared" / "step"

sys.path.insert(0, str(HERE))  # the sample and probe modules beside the tests


@pytest.fixture(scope="session")
def shared_step() -> Path:
    """Folder of real STEP files made by others."""
    if not SHARED_STEP.is_dir():
        pytest.skip("the folder ../shared/step with real STEP files is not here")
    return SHARED_STEP


@pytest.fixture
def probe(monkeypatch: pytest.MonkeyPatch) -> str:
    """Name of the module with what tests run in a child process, which then finds it."""
    monkeypatch.setenv("PYTHONPATH", str(HERE))
    return "step_probe"
