"""Rest lengths as smooth functions of the menisci's places.

Inside, an edge is a fixed fraction of s_B - s_A. In an outer region of length a the node k edges away
from the meniscus lies at

    w (G^{k/n} - 1),   G = 1 + a/w

from it: spacing w log(G)/n in the boundary layer beside the meniscus, growing exponentially beyond the
layer's length w, uniform where a is small. As the menisci move, so do the nodes; the energy stays
smooth in s_A and s_B.
"""

from __future__ import annotations

from derod.algebra.jit import inlined, kernel
from derod.rod.unknowns import S_A, S_B


@inlined
def outer_lengths(mesh, region, sign, nearest, step, rest, slope, curve):
    """Fill the lengths of the outer region of length ``region``, from its edge ``nearest`` the meniscus.

    ``sign`` is the region's growth with its meniscus' place, ``step`` the way to the next edge.
    """
    n = mesh.outside
    g = 1 + region / mesh.layer
    ratio = g ** (1.0 / n)
    power, first, second = 1.0, 0.0, 0.0  # G^{k/n} and its derivatives by a, over w
    j = nearest
    for k in range(1, n + 1):
        e = k / n
        new_power = power * ratio
        new_first = e * new_power / g
        new_second = (e - 1) * new_first / (g * mesh.layer)
        rest[j] = mesh.layer * (new_power - power)
        slope[j] = sign * (new_first - first)
        curve[j] = new_second - second
        power, first, second = new_power, new_first, new_second
        j += step


@kernel
def lay_grid(mesh, length, b, kin):
    """Fill the rest lengths and their derivatives by s_A and s_B; without menisci they are fixed."""
    if kin.node_b < kin.node_a:
        for i in range(mesh.inside.size):
            kin.rest[1 + i] = mesh.inside[i] * length
        return
    outer_lengths(mesh, b[S_A], 1.0, kin.node_a, -1, kin.rest, kin.slope[0], kin.curve[0])
    outer_lengths(
        mesh, length - b[S_B], -1.0, kin.node_b + 1, 1, kin.rest, kin.slope[1], kin.curve[1]
    )
    wetted = b[S_B] - b[S_A]
    for i in range(mesh.inside.size):
        j = kin.node_a + 1 + i
        kin.rest[j] = mesh.inside[i] * wetted
        kin.slope[0, j] = -mesh.inside[i]
        kin.slope[1, j] = mesh.inside[i]
