import numpy as np
import pytest

from derod.branches.half_rod.parameters import Parameters
from derod.branches.paths.arc import Control
from derod.branches.paths.catalogue import Catalogue

FAST = Control(tolerance=1e-9, largest_step=0.4, turning=0.4)


@pytest.fixture(scope="session")
def catalogue():
    """The paper's rod (v0 = 2e-4) with Ax and the succession traced."""
    out = Catalogue(Parameters(), FAST)
    out.ax()
    list(out.succession())
    return out


@pytest.fixture(scope="session")
def branches(catalogue):
    """Ax, 3D, L2 and 3D-L2 of that rod, refined, with errors and unstable modes."""
    return {name: catalogue.store(path) for name, path in list(catalogue.paths.items())}


@pytest.fixture(scope="session")
def branch_file(tmp_path_factory, branches):
    from derod.branches.files.writing import write_branches

    path = tmp_path_factory.mktemp("branches") / "text.h5"
    write_branches(path, Parameters(), list(branches.values()), "text of the scene")
    return path


@pytest.fixture
def rng():
    return np.random.default_rng(7)
