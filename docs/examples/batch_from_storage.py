"""Run a batch whose files are in an object store: copy them here, run, and copy the results back.

``python batch_from_storage.py s3://bucket/monday s3://bucket/monday-results [options of wpcal batch]`` expects jobs.csv
and all files that it names below the first address. Results that are there already are continued. It needs fsspec, and
for each kind of address its package: s3fs, gcsfs, adlfs.
"""

import subprocess
import sys
import tempfile

import fsspec.core


def main(source: str, target: str, *options: str) -> int:
    """Return the exit code of the batch."""
    with tempfile.TemporaryDirectory() as here:
        files, place = fsspec.core.url_to_fs(source)
        files.get(place, f"{here}/list", recursive=True)
        results, place = fsspec.core.url_to_fs(target)
        again = ["--resume"] if results.exists(place) else []
        if again:
            results.get(place, f"{here}/results", recursive=True)
        command = ["wpcal", "batch", f"{here}/list/jobs.csv", "-o", f"{here}/results"]
        code = subprocess.run([*command, *again, *options], check=False).returncode
        results.put(f"{here}/results/", place, recursive=True)
    return code


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
