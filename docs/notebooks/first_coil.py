# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # A first coil
#
# A rod is pushed into a drop through two small openings, the menisci. The drop wants to hold as much of it
# as it can; the rod would rather be straight. This notebook pushes one, looks at what it does, and asks the
# run a few questions. It takes some seconds once the kernels are compiled (half a minute, the first time on
# a machine).
#
# Lengths are in D, the drop's diameter; forces in K0/D^2; energies in K0/D.

# %%
import numpy as np

import derod

# %% [markdown]
# ## The scene
#
# The paper's rod: ten drop diameters long, with a wall that is nearly hard. Scenes like it ship with the
# package (`derod.Scene("quick")`); here one is built in code. The places in `at` are landed on exactly.

# %%
scene = derod.Scene(
    rod={"length": 10, "bending": 1, "twisting": 0.9},
    drop={"capillary_force": 20, "wall_strength": 2e-4, "wall_softness": 0.1},
    push={"start": "0.001 pi", "stop": "1 pi", "at": ["0.242 pi", "0.5 pi", "1 pi"]},
    mesh={"edges": 150},
)
scene

# %% [markdown]
# ## The push
#
# One end clamp is moved toward the other, a little at a time. At every increment the rod settles into a
# stable equilibrium; what happened on the way is an event.

# %%
run = derod.push(scene)
for event in run.events:
    if event.kind != "halving":  # of an increment, for accuracy's sake
        print(f"{event.kind} at {event.end_shortening / np.pi:.4f} pi: {event.message}")
print(run[-1])

# %% [markdown]
# The tension rises until the rod has buckled and bent along the wall. At 0.24 pi the planar coil becomes
# unstable, and the push is kicked off it into space.

# %%
run.plot("path", at="0.242 pi, 0.5 pi, 1 pi")

# %%
run.plot("shapes", at="0.242 pi, 0.5 pi, 1 pi")

# %% [markdown]
# ## Why it left the plane
#
# The softest modes at 0.242 pi, just before. The first moves the coil in its thinnest direction: out of the
# plane. Its eigenvalue comes down to zero at 0.243 pi. Afterwards, in space, that mode is stiff again.

# %%
before, after = run.at("0.242 pi"), run.at("0.3 pi")
print("before", before.modes(4).eigenvalues)
print("after ", after.modes(4).eigenvalues)
run.plot("modes", at="0.242 pi", modes=2)

# %%
run.plot("eigenvalues")

# %% [markdown]
# ## Questions
#
# Every column of the table and every field along the rod is an array.

# %%
inside = run["wetted_length"] / scene.rod.length
print(f"{inside[0]:.0%} of the rod is in the drop at first, {inside[-1]:.0%} at the end")
last = run[-1]
print(f"largest curvature {last.curvature.max():.2f} / D")
print(f"largest push of the wall {last.wall_pressure.max():.1f} K0 / D^3")
assert (run["unstable_modes"] == 0).all()

# %% [markdown]
# How exact is it? Push on half the edges too, and the two together estimate their error.

# %%
better = derod.push(scene, extrapolate=True)
print(f"estimated error of t: {better.extrapolated['end_tension_error'].max():.1e} K0/D^2")
