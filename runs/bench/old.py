"""An older version of derod, taken out of this repository's history."""

from __future__ import annotations

import io
import subprocess
import tarfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
VERSION_0_1 = "9e95062"


def old_sources(folder: Path, commit: str = VERSION_0_1) -> Path:
    """Take the package at ``commit`` out of the history into ``folder``; return the folder."""
    command = ["git", "-C", str(ROOT), "archive", commit, "derod"]
    archive = subprocess.run(command, capture_output=True, check=True).stdout
    with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
        tar.extractall(folder, filter="data")
    return folder
