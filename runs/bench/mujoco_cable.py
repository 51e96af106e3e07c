"""MuJoCo's cable (a plugin of its chain of rigid bodies, before version 4) on the clamped-clamped elastica.

One element more than the rod has: clamps lie at the middles of the end elements, or every answer would be
of first order. The first element is fixed, the last one is welded to a body that is moved inward by a smooth
step; a weld is soft, and made as stiff as the time step allows. A motion, damped in its joints, that has
nearly come to rest; the tension is the weld's force. The plugin's moments are explicit: the time step falls
like h^2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import mujoco
import numpy as np

from bench.elastica import SHORTENING

RADIUS = 0.01  # L
MODEL = """
<mujoco><extension><plugin plugin="mujoco.elasticity.cable"/></extension>
<option gravity="0 0 0" timestep="{step}" integrator="implicitfast"/>
<worldbody>
<composite type="cable" curve="s" count="{nodes} 1 1" size="{size}" initial="none">
<plugin plugin="mujoco.elasticity.cable"><config key="twist" value="{twist}"/>
<config key="bend" value="{bend}"/><config key="vmax" value="0"/></plugin>
<joint kind="main" damping="{damping}" armature="{armature}"/>
<geom type="capsule" size="{radius}" density="{density}" contype="0" conaffinity="0"/>
</composite>
<body name="end" mocap="true" pos="{place} 0 0"/></worldbody>
<equality><weld body1="B_last" body2="end" solref="{soft} 1" solimp="0.9999 0.9999 0.001"/></equality>
</mujoco>"""


class Settings(NamedTuple):
    """What is scanned."""

    elements: int
    rise: float = 1.0  # time of the push, sqrt(m L^4 / K)
    hold: float = 1.0
    damping: float = 0.02  # of every joint
    courant: float = 0.05  # time step, of h^2

    def __str__(self) -> str:
        return f"push {self.rise:g}, hold {self.hold:g}, damping {self.damping:g}, dt {self.courant:g} h^2"


SCAN = [
    Settings(elements, times, times, damping, courant)
    for elements in (10, 20)
    for times in (0.25, 0.5, 1.0)
    for damping in (0.05, 0.2, 0.5)
    for courant in (0.1, 0.2, 0.4)
]


class Answer(NamedTuple):
    """What it settled into."""

    iterations: int  # time steps
    tension: float  # K/L^2
    height: float  # L


def solve(settings: Settings) -> Answer | None:
    """Push and settle; None where it is not at rest, or no longer finite."""
    n = settings.elements
    h = 1 / n
    step = settings.courant * h * h
    stiff = 1 / (math.pi * RADIUS**4 / 4)
    text = MODEL.format(
        step=step, nodes=n + 2, size=1 + h, twist=stiff / 2, bend=stiff, damping=settings.damping,
        armature=1e-3 * h, radius=RADIUS, density=1 / (math.pi * RADIUS**2), place=1.0, soft=10 * step,
    )  # fmt: skip
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    middle = 1 + n // 2
    steps = round((settings.rise + settings.hold) / step)
    for _ in range(steps):
        part = min(data.time / settings.rise, 1.0)
        data.mocap_pos[0, 0] = 1.0 - SHORTENING * part * part * (3 - 2 * part)
        data.xfrc_applied[middle, 2] = 5.0 if data.time < 0.2 * settings.rise else 0.0
        mujoco.mj_step(model, data)
    if not np.isfinite(data.qvel).all() or np.abs(data.qvel).max() > 1.0:
        return None
    # the weld's first row is along the axis; the middle is a body's origin where n is odd
    height = float(np.abs(data.xpos[1:, 2]).max())
    return Answer(steps, -abs(float(data.efc_force[0])), height)
