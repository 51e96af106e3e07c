import numpy as np
import pytest

from derod.views.stream.drawing import Batch, draw, shown_nodes
from tests.synthetic import SCENE_TEXT, make_frame, small_scene


def batch(count=3, edges=24):
    return Batch.of([make_frame(i, edges) for i in range(count)])


@pytest.mark.parametrize("color", ["curvature", "tension", "wall", "twist"])
def test_every_column_has_an_item_a_frame(color):
    for column in draw(batch(), small_scene(), color):
        for name, items in column.fields.items():
            assert len(items) == 3, (column.entity, name)


def test_capillary_energy_is_counted_from_the_reference():
    frames = batch()
    frames.rows["energy_capillary"] = -21.0
    columns = draw(frames, small_scene(), "wall")
    shown = next(column for column in columns if column.entity == "plots/energy/capillary")
    assert shown.fields["scalars"][1] == pytest.approx([20 * (1 + 0.02) - 21])


def test_a_scene_without_a_drop_has_nothing_wet():
    from derod.scene import parse_scene

    head, _, rest = SCENE_TEXT.partition("[drop]")
    scene = parse_scene(head + rest[rest.index("[push]") :] + "[model]\ndrop = false\n")
    frames = batch()
    frames.drop_center[:] = np.nan
    entities = {column.entity: column for column in draw(frames, scene, "curvature")}
    assert "world/menisci/points" not in entities
    assert "world/wall" not in entities
    center = np.array(entities["world/drop"].fields["translation"])[:, 0]
    assert center == pytest.approx((frames.positions[:, 0] + frames.positions[:, -1]) / 2)


def test_very_fine_rods_are_thinned():
    assert shown_nodes(401).tolist() == list(range(401))
    assert len(shown_nodes(6401)) <= 1202
    assert shown_nodes(6401)[-1] == 6400
