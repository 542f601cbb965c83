"""The committed bundles equal a fresh build of their source."""

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
BUNDLES = ROOT / "wpcal" / "pages" / "bundles"
SOURCE = ROOT / "wpcal" / "pages" / "source"


def test_a_rebuild_gives_the_same_bytes(tmp_path: Path) -> None:
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not here; the bundles are compared where it is")
    if not (SOURCE / "node_modules" / "esbuild").is_dir():
        pytest.skip("wpcal/pages/source/node_modules is not here; `make viewer` installs it")
    command = [node, "build.mjs", "--out", str(tmp_path)]
    done = subprocess.run(command, cwd=SOURCE, capture_output=True, text=True, check=False, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")
    built = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    kept = {file.name: file.read_bytes() for file in BUNDLES.iterdir()}
    assert built.keys() == kept.keys()
    changed = [name for name in built if built[name] != kept[name]]
    assert not changed, f"{', '.join(changed)}: run `make viewer` and commit"


def test_the_lock_file_names_no_host_and_no_folder() -> None:
    text = (SOURCE / "package-lock.json").read_text(encoding="utf-8")
    assert '"resolved"' not in text
    assert "file:" not in text


def test_the_licence_of_three_js_travels_with_it() -> None:
    head = (BUNDLES / "viewer.js").read_text(encoding="utf-8")[:2000]
    assert "three.js authors" in head
    assert "THE SOFTWARE IS PROVIDED" in head
