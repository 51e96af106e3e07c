"""Pictures of a run as rerun shows it, without a display: ``python viz/rerun_picture.py RUN -o
OUT.png``.

Needs a software Vulkan driver (Debian: mesa-vulkan-drivers).
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from io import BytesIO
from pathlib import Path

from derod.cli import carry_out
from derod.files.outputs import check_output, replacing
from derod.terminal import say_done
from derod.views.stream.replay import replay_file
from derod.views.stream.target import parse_target, proxy_url
from derod.views.stream.viewers import HOST, close_recording, free_port, start_viewer

BAR = 0.0195  # of the picture's width: how high the viewer's top bar is
SETTLE = 12.0  # s until the viewer has loaded everything and its notices are gone


def main(arguments: list[str] | None = None) -> int:
    """Replay the file into a viewer without a window and take its picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", help="run or branch file, or .rrd")
    parser.add_argument("-o", "--output", required=True, help="PNG to write")
    parser.add_argument("--force", action="store_true", help="replace the PNG if it exists")
    parser.add_argument("--time", default="increment=-1", help="TIMELINE=VALUE to show")
    parser.add_argument("--color", default="curvature", help="what the rod is coloured by")
    parser.add_argument("--width", type=int, default=1400, help="of the picture, pixels")
    args = parser.parse_args(arguments)
    check_output(args.output, force=args.force, inputs=[args.file])
    with tempfile.TemporaryDirectory() as folder:
        recording = args.file
        if not recording.endswith(".rrd"):
            recording = str(Path(folder) / "replay.rrd")
            close_recording(
                replay_file(args.file, parse_target(recording), args.color).recording, 60.0
            )
        timeline, _, value = args.time.partition("=")
        with replacing(args.output, force=args.force) as passing:
            passing.write_bytes(picture(recording, timeline, float(value), args.width))
    say_done(args.output)
    return 0


def picture(recording: str, timeline: str, value: float, width: int) -> bytes:
    """The PNG of a headless viewer that shows ``recording`` at a time; -1 is its end.

    The viewer listens on this machine only. Its own bar, with badges about this machine, is cut off.
    """
    from rerun.experimental import ViewerClient

    port = free_port(9881)
    process = start_viewer(port, None, options=["--headless"])
    try:
        viewer = ViewerClient(proxy_url(HOST, port))
        viewer.open(recording)
        time.sleep(SETTLE)
        if value >= 0:
            if timeline == "end_shortening":
                viewer.set_time(timeline, duration=value, play_state="paused")
            else:
                viewer.set_time(timeline, sequence=int(value), play_state="paused")
        time.sleep(2.0)
        return without_bar(viewer.take_screenshot(max_size=width))
    finally:
        process.terminate()
        process.wait()


def without_bar(png: bytes) -> bytes:
    """The picture without the viewer's top bar."""
    from PIL import Image

    image = Image.open(BytesIO(png))
    out = BytesIO()
    image.crop((0, round(BAR * image.width), image.width, image.height)).save(out, "PNG")
    return out.getvalue()


if __name__ == "__main__":
    sys.exit(carry_out(main))
