"""The web viewer in a real headless Chromium: ``pytest -m browser``.

Needs Chromium (Debian: apt-get install chromium) and node; playwright-core comes from npm, into a
folder of its own, or from DEROD_PLAYWRIGHT, a folder whose node_modules has it.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import derod
from tests.synthetic import small_scene

pytestmark = pytest.mark.browser
HERE = Path(__file__).parent
WAIT = 25  # s until a software renderer has drawn the scene
WATER = (30, 70)  # how much more blue than red the drop's pixels are, at least and typically


@pytest.fixture(scope="module")
def chromium() -> str:
    for name in ("chromium", "chromium-browser", "google-chrome"):
        found = shutil.which(name)
        if found is not None:
            return found
    pytest.skip("no Chromium on this machine (Debian: apt-get install chromium)")


@pytest.fixture(scope="module")
def playwright(tmp_path_factory) -> str:
    if shutil.which("node") is None:
        pytest.skip("no node on this machine (Debian: apt-get install nodejs npm)")
    given = os.environ.get("DEROD_PLAYWRIGHT")
    if given is not None:
        return given
    if shutil.which("npm") is None:
        pytest.skip("no npm to fetch playwright-core with; DEROD_PLAYWRIGHT may name a folder")
    folder = tmp_path_factory.mktemp("playwright")
    command = [
        "npm",
        "install",
        "--no-save",
        "--silent",
        "--prefix",
        str(folder),
        "playwright-core",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    if done.returncode != 0:
        pytest.skip(f"npm could not fetch playwright-core: {done.stderr[-200:]}")
    return str(folder)


@pytest.fixture(scope="module")
def run_file(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("run") / "coil.h5"
    derod.push(small_scene(mesh__edges=120, push__stop="0.5 pi", push__at=[]), path)
    return path


def test_the_web_viewer_shows_the_coil_and_its_curves(chromium, playwright, run_file, tmp_path):
    from PIL import Image

    view = subprocess.Popen(
        [sys.executable, "-m", "derod", "view", str(run_file), "--web"],
        stdout=subprocess.PIPE,
        text=True,
    )
    picture = tmp_path / "page.png"
    try:
        url = view.stdout.readline().strip()
        assert url.startswith("http://127.0.0.1:")
        listening = subprocess.run(
            ["ss", "-ltn"], capture_output=True, text=True, check=False
        ).stdout
        port = url.split(":")[2].split("/")[0]
        if listening:
            assert f"127.0.0.1:{port}" in listening
            assert f"0.0.0.0:{port}" not in listening
        command = ["node", str(HERE / "browse.mjs"), playwright, chromium]
        command += [url + "&renderer=webgl", str(picture), str(WAIT)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=200)
        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)["errors"] == []
    finally:
        view.send_signal(signal.SIGINT)
        view.wait(20)
    keep = os.environ.get("DEROD_KEEP_PICTURES")
    if keep:
        shutil.copy(picture, Path(keep) / "web-viewer.png")
    with Image.open(picture) as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    colors = len(np.unique(pixels.reshape(-1, 3), axis=0))
    assert colors > 2000  # a loading page has a few dozen
    space, curves = pixels[:, : 3 * 1400 // 5], pixels[:, 3 * 1400 // 5 :]
    water = (space[..., 2] - space[..., 0] > WATER[0]) & (space[..., 2] > 60)
    assert water.mean() > 0.03, "no drop to be seen"
    line = (abs(curves - [86, 180, 233]).sum(axis=-1)) < 40
    assert line.sum() > 100, "no curve to be seen"
