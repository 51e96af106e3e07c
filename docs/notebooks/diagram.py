# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # A bifurcation diagram, with a push on it
#
# A push tells what happens to a rod that is pushed slowly. All the equilibria that it might have met are
# another question: they are solutions of a boundary-value problem, and `derod.branch` follows them with a
# solver that shares no code with the discrete rod. Held against each other, the two check one another.

# %%
import numpy as np

import derod

# %% [markdown]
# ## The branches
#
# `Ax` is the planar path that begins at the straight rod's buckling; `3D` leaves it at a pitchfork.

# %%
branches = derod.branch("quick", paths=["Ax", "3D"])
branches

# %%
for name in branches.keys():  # noqa: SIM118
    for point in branches[name].bifurcations:
        print(f"{name:3} {point['kind'].decode():10} at {point['end_shortening'] / np.pi:.5f} pi")

# %% [markdown]
# ## The push on it

# %%
run = derod.push("quick")
run.plot("path", branches)

# %% [markdown]
# Solid lines are stable and dashed ones are not; the dots are the push. It follows `Ax` to the pitchfork and
# goes on along `3D`.

# %% [markdown]
# ## How well they agree
#
# Every increment is held against the branch it is on, solved at the same end-shortening.

# %%
found = derod.compare(run, branches)
for quantity, (error, where) in found.worst.items():
    print(f"{quantity:14} {error:.1e} at {where / np.pi:.2f} pi")

# %%
assert not found.exceeds(1e-3)
run.plot("compare", branches)

# %% [markdown]
# The error is that of the mesh: 150 edges, of fourth order. Twice the edges, a sixteenth of it.

# %%
finer = derod.push(derod.Scene("quick", {"mesh.edges": 300}))
worst = derod.compare(finer, branches).worst
for quantity in found.worst:
    print(f"{quantity:14} {worst[quantity][0] / found.worst[quantity][0]:.3f} of it")

# %% [markdown]
# ## A state on a branch
#
# Branches can be solved at any end-shortening, also where they are unstable.

# %%
for landing in branches["Ax"].at(0.5 * np.pi):
    tension, energy = landing.values["end_tension"], landing.values["energy_hat"]
    print(f"t = {tension:.6f}, E_hat = {energy:.6f}, unstable modes: {landing.unstable_modes}")
