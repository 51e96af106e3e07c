"""Rest lengths as smooth functions of the menisci's places.

Inside, an edge is a fixed fraction of s_B - s_A. In an outer region of length a the node k edges away
from the meniscus lies at

    w (G^{k/n} - 1),   G = 1 + a/w

from it: spacing w log(G)/n in the boundary layer beside the meniscus, growing exponentially beyond the
layer's length w, uniform where a is small. Under a heavy drop the clamps bend the rod as well, and each half
of the region is graded in this way, toward the meniscus and toward the clamp. As the menisci move, so do
the nodes; the energy stays smooth in s_A and s_B.
"""

from __future__ import annotations

from derod.algebra.jit import kernel
from derod.rod.unknowns import S_A, S_B


@kernel
def fill_graded(layer, region, share, count, sign, nearest, step, rest, slope, curve):
    """Fill the lengths of ``count`` edges on the part ``share`` of an outer region of length ``region``.

    They grow away from the edge ``nearest``; ``step`` is the way to the next one, ``sign`` the region's
    growth with its meniscus' place.
    """
    g = 1 + share * region / layer
    ratio = g ** (1.0 / count)
    power, first, second = 1.0, 0.0, 0.0  # G^{k/n} and its derivatives by the length, over w
    j = nearest
    for k in range(1, count + 1):
        e = k / count
        new_power = power * ratio
        new_first = e * new_power / g
        new_second = (e - 1) * new_first / (g * layer)
        rest[j] = layer * (new_power - power)
        slope[j] = sign * share * (new_first - first)
        curve[j] = share * share * (new_second - second)
        power, first, second = new_power, new_first, new_second
        j += step


@kernel
def fill_outer(mesh, region, sign, meniscus, clamp, step, rest, slope, curve):
    """Fill the lengths of the outer region between the edges ``meniscus`` and ``clamp``.

    Where the clamps bend the rod too, half of it is graded toward the clamp.
    """
    n = mesh.outside
    if not mesh.clamp_layers:
        fill_graded(mesh.layer, region, 1.0, n, sign, meniscus, step, rest, slope, curve)
        return
    m = n // 2
    fill_graded(mesh.layer, region, 0.5, n - m, sign, meniscus, step, rest, slope, curve)
    fill_graded(mesh.layer, region, 0.5, m, sign, clamp, -step, rest, slope, curve)


@kernel
def lay_grid(mesh, length, b, kin):
    """Fill the rest lengths and their derivatives by s_A and s_B; without menisci they are fixed."""
    if kin.node_b < kin.node_a:
        for i in range(mesh.inside.size):
            kin.rest[1 + i] = mesh.inside[i] * length
        return
    last = kin.rest.size - 2
    fill_outer(mesh, b[S_A], 1.0, kin.node_a, 1, -1, kin.rest, kin.slope[0], kin.curve[0])
    fill_outer(
        mesh, length - b[S_B], -1.0, kin.node_b + 1, last, 1, kin.rest, kin.slope[1], kin.curve[1]
    )
    wetted = b[S_B] - b[S_A]
    for i in range(mesh.inside.size):
        j = kin.node_a + 1 + i
        kin.rest[j] = mesh.inside[i] * wetted
        kin.slope[0, j] = -mesh.inside[i]
        kin.slope[1, j] = mesh.inside[i]
