"""The key of the 3D view, and the soft wall's edge."""

from __future__ import annotations

import numpy as np
import pytest

from derod.views.stream.legend import wall_edge
from tests.stream.reading import read_rrd
from tests.synthetic import small_scene


@pytest.mark.parametrize("color", ["curvature", "tension", "wall", "twist"])
def test_the_scale_is_that_of_the_rods_colour(tmp_path, color):
    import rerun as rr

    from derod.views.stream.stage import Stage
    from derod.views.stream.viewers import close_recording

    target = tmp_path / "a.rrd"
    recording = rr.RecordingStream("derod")
    recording.save(str(target))
    Stage(recording, small_scene(), color, live=False)
    assert close_recording(recording, 20) is None
    contents = read_rrd(target)
    assert "Image:buffer" in contents["legend/scale"].static
    assert "Points2D:labels" in contents["legend/ticks"].static


def test_the_edge_is_where_the_wall_is_singular():
    circles = wall_edge(0.1).strips.as_arrow_array().to_pylist()
    assert len(circles) == 3
    for circle in circles:
        assert np.linalg.norm(np.array(circle), axis=1) == pytest.approx(0.55, rel=1e-6)
