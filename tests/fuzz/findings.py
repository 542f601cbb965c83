"""Inputs with which a reader did something wrong once: kept as small files, and tested in CI."""

import hashlib
from pathlib import Path

FINDINGS = Path(__file__).parent / "findings"  #: One folder per reader.


def keep(name: str, data: bytes) -> Path:
    """Write an input with a fault where the tests find it, and return its file."""
    path = FINDINGS / name / hashlib.sha256(data).hexdigest()[:12]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
    return path
