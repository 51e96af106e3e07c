"""Fits of synthetic curves with 1 % noise: how often the truth is within two standard errors, and how fast.

python runs/fit_recovery.py                # 100 draws, two free parameters; some six minutes
python runs/fit_recovery.py --draws 10 --rows 40

Every draw has a truth of its own (f_gamma from 12 to 35, rod.bending from 0.5 to 2, Latin hypercube), 40
rows to 1.2 pi at 40 edges, gaussian noise of 1 % of each force, and a fit that starts at f_gamma = 20,
rod.bending = 1. The seed is fixed. Set OPENBLAS_NUM_THREADS=1; times are CPU times.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from scipy.stats import binom, qmc

import derod
from derod.fits.data import make_data
from derod.fits.model import Model
from derod.fits.solving import fit

FREE = ("drop.capillary_force", "rod.bending")
LOW, HIGH = (12.0, 0.5), (35.0, 2.0)
NOISE = 0.01


def main() -> None:
    """Fit every draw and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--rows", type=int, default=40)
    parser.add_argument("--seed", type=int, default=17)
    args = parser.parse_args()
    scene = derod.Scene("paper-text", {"mesh.edges": 40})
    places = np.linspace(0.03, 1.2, args.rows) * np.pi
    empty = make_data(places, np.zeros(args.rows))
    chance = np.random.default_rng(args.seed)
    truths = qmc.scale(qmc.LatinHypercube(2, rng=args.seed).random(args.draws), LOW, HIGH)
    offs, times, pushes, converged, warned = [], [], [], 0, []
    for truth in truths:
        force = Model(scene, FREE, empty)(truth)
        error = NOISE * np.abs(force)
        data = make_data(places, force + error * chance.standard_normal(args.rows), error=error)
        began = time.process_time()
        found = fit(data, scene, FREE)
        times.append(time.process_time() - began)
        pushes.append(found.pushes)
        converged += found.converged
        warned.append(bool(found.warnings))
        offs.append((found.values - truth) / found.errors)
    off = np.abs(np.array(offs))
    print(f"{args.draws} draws, {args.rows} rows, {NOISE:.0%} noise: {converged} converged")
    for k, key in enumerate(FREE):
        within = np.count_nonzero(off[:, k] <= 2.0)
        rms = np.sqrt(np.mean(off[:, k] ** 2))
        print(
            f"  {key:22} within 2 standard errors in {within} of {args.draws}; "
            f"median off by {np.median(off[:, k]):.2f}, rms {rms:.2f}, at most {off[:, k].max():.1f}"
        )
    together = int(np.count_nonzero((off <= 2.0).all(axis=1)))
    print(f"  both at once in {together}")
    astray = (off > 5.0).any(axis=1)
    told = np.count_nonzero(astray & np.array(warned))
    print(f"  {np.count_nonzero(astray)} off by more than 5, in another minimum; warned of: {told}")
    low, high = binom.interval(0.95, args.draws, 0.9545)
    print(f"  right errors would give {0.9545 * args.draws:.1f} each, {low:.0f} to {high:.0f}")
    print(
        f"  a fit: {np.median(times):.1f} s, at most {max(times):.1f} s; {np.median(pushes):.0f} pushes"
    )


if __name__ == "__main__":
    main()
