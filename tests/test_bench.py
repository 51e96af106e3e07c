"""What the studies in runs/ rest on: the peer's forces, the elastica's closed form, coils counted."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest

RUNS = Path(__file__).parents[1] / "runs"


@pytest.fixture(autouse=True)
def studies_importable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(RUNS), *sys.path])


def test_the_drop_given_to_peers_pushes_with_the_gradient_of_its_energy() -> None:
    forcing = importlib.import_module("bench.forcing")
    n, h = 61, 0.05
    s = (np.arange(n) - 0.5) * h
    x = np.array([0.05 * np.sin(3 * s), 0.03 * np.cos(2 * s), s])
    centre = np.array([0.01, 0.02, 0.5 * s[-1]])

    def energy(x: np.ndarray, centre: np.ndarray) -> float:
        room = np.zeros(n), np.zeros((3, n)), np.zeros(3)
        return sum(forcing.drop_forces(x, centre, h, 2e-2, 0.1, 20.0, *room)[:2])

    force, pull = np.zeros((3, n)), np.zeros(3)
    forcing.drop_forces(x, centre, h, 2e-2, 0.1, 20.0, np.zeros(n), force, pull)
    step = 1e-6
    for k in range(3):
        for j in range(n):
            shift = np.zeros_like(x)
            shift[k, j] = step
            slope = (energy(x + shift, centre) - energy(x - shift, centre)) / (2 * step)
            assert force[k, j] == pytest.approx(-slope, abs=1e-6)
        move = step * np.eye(3)[k]
        slope = (energy(x, centre + move) - energy(x, centre - move)) / (2 * step)
        assert pull[k] == pytest.approx(-slope, abs=1e-6)


def test_no_force_jumps_as_a_meniscus_passes_a_node() -> None:
    """The drop slides over two edges: ten times finer steps, ten times smaller changes."""
    forcing = importlib.import_module("bench.forcing")
    n, h = 61, 0.05
    s = (np.arange(n) - 0.5) * h
    x = np.array([0.05 * np.sin(3 * s), np.zeros(n), s])

    def largest_change(steps: int) -> float:
        pulls = []
        for z in np.linspace(1.4, 1.4 + 2 * h, steps):
            pull, place = np.zeros(3), np.array([0.0, 0.0, z])
            forcing.drop_forces(x, place, h, 2e-2, 0.1, 20.0, np.zeros(n), np.zeros((3, n)), pull)
            pulls.append(pull[2])
        return float(np.abs(np.diff(pulls)).max())

    assert largest_change(2001) < 0.2 * largest_change(201)


def test_the_elastica_of_the_literature() -> None:
    load, height = importlib.import_module("bench.elastica").exact_elastica()
    assert load == pytest.approx(43.92916, abs=1e-5)
    assert height == pytest.approx(0.2663186, abs=1e-7)


def test_coils_of_a_helix_are_its_turns() -> None:
    coils = importlib.import_module("growth").coils
    angle = np.linspace(0, 6 * np.pi, 601)  # three turns
    helix = np.stack([np.cos(angle), np.sin(angle), 0.1 * angle], axis=1)
    place = angle * np.hypot(1, 0.1)
    # the tangent of this helix turns by cos(pitch) less than its angle
    expected = 3 / np.hypot(1, 0.1)
    assert coils(helix, place, (-1.0, place[-1] + 1)) == pytest.approx(expected, rel=0.01)
    assert coils(helix, place, (0.0, place[300])) == pytest.approx(0.5 * expected, rel=0.02)


def test_rows_survive_the_csv(tmp_path: Path) -> None:
    import csv

    row = importlib.import_module("bench.row")
    rows = [row.Row("elastica", "derod", "implicit", 50, "default", 0.1, 0.2, note="a, b")]
    row.write_csv(tmp_path / "rows.csv", rows)
    with (tmp_path / "rows.csv").open() as file:
        (read,) = csv.DictReader(file)
    assert read["note"] == "a, b" and float(read["cpu"]) == 0.2 and int(read["edges"]) == 50
