"""AUTO's table: one line a point, labels at special points."""

import numpy as np

from derod.branches.files.export import COLUMNS, auto_table
from derod.branches.files.record import open_branches


def test_table(branch_file):
    with open_branches(branch_file) as file:
        lines = auto_table(file).splitlines()
        rows = [line.split() for line in lines if not line.startswith("   0")]
        assert len(rows) == sum(len(b) for b in file.values())
        assert {len(row) for row in rows} == {4 + len(COLUMNS)}
        labels = [int(row[3]) for row in rows if row[3] != "0"]
        assert labels == list(range(1, len(labels) + 1))
        first = file.names[0]
        own = np.array([[float(x) for x in row[4:]] for row in rows if row[0] == "1"])
        assert np.allclose(own[:, 0], file[first].table["end_shortening"], rtol=1e-10)
        types = [int(row[2]) for row in rows if row[0] == "1"]
        kinds = [types[b["index"]] for b in file[first].bifurcations]
        expected = {"pitchfork": 1, "fold": 5}
        assert kinds == [expected[b["kind"].decode()] for b in file[first].bifurcations]
        stable = [int(row[1]) < 0 for row in rows if row[0] == "1"]
        assert stable == list(file[first].table["unstable_modes"] == 0)
