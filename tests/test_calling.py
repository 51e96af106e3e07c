"""``derod.push`` is a function for users, and a package for what imports its parts."""

from __future__ import annotations

import inspect
import subprocess
import sys

import pytest

import derod
import derod.push.frames
from derod.api import push
from derod.errors import SceneError


def test_the_package_is_called_as_the_function() -> None:
    with pytest.raises(SceneError, match="needs a scene"):
        derod.push(None)
    assert inspect.signature(derod.push) == inspect.signature(push)
    assert inspect.getdoc(derod.push) == inspect.getdoc(push)


@pytest.mark.parametrize(
    "before", ["", "import derod.push.frames", "derod.open_run", "derod.push", "import derod.cli"]
)
def test_whatever_was_imported_before(before: str) -> None:
    code = (
        f"import derod\n{before}\ntry:\n    derod.push(None)\n"
        "except derod.SceneError as error:\n    print(error)\n"
        "from derod.push.frames import Frame\nimport derod.push.frames as f\nassert f.Frame is Frame\n"
        "try:\n    derod.push(None)\nexcept derod.SceneError as error:\n    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.count("needs a scene") == 2, done.stderr
