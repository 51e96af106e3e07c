"""A tenth of the faults of ``runs/faults.py``; each promise of docs/reliability.md is held."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import pytest

TRIED = {
    "kills.kill_chains": 10,
    "kills.copy_kills": 5,
    "kills.full_disks": 3,
    "corruptions.flips_of_finished": 100,
    "corruptions.flips_of_killed": 100,
    "corruptions.flips_of_live": 10,
    "corruptions.flips_of_branches": 50,
    "corruptions.cuts": 60,
    "corruptions.resumes": 30,
    "foreign.hostile_files": 90,
    "foreign.noise": 50,
    "mutations.mutated_scenes": 500,
    "mutations.values": 200,
    "mutations.pushes": 10,
    "rivals.two_writers": 2,
    "rivals.writer_and_resumer": 2,
    "rivals.two_resumers": 2,
    "signalled.signals": 9,
    "signalled.storms": 4,
    "printed.broken_outputs": 1,
    "printed.refused_outputs": 1,
}


@pytest.mark.validation
@pytest.mark.parametrize("place", TRIED)
def test_faults(place: str, tmp_path: Path) -> None:
    module, _, function = place.partition(".")
    run = getattr(import_module(f"tests.validation.faults.{module}"), function)
    found = run(tmp_path, TRIED[place])
    assert found.trials >= 1 and found.failures == []
