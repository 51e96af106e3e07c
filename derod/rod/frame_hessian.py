"""Second derivatives by strains turned into those by edges and their angles, for the Hessian's edge form.

Let xi be the body rotations of the frames left and right of a vertex: Q -> exp(-[xi_l]) Q exp([xi_r]). Every
strain is a function of parts of Q, which are linear in Q, whose second derivatives are

    D2 Q[xi, xi] = [xi_l]^2 Q - 2 [xi_l] Q [xi_r] + Q [xi_r]^2

A change de of an edge and dtheta of its angle turn its frame, to second order, with a = d_1.de/|e|,
b = d_2.de/|e|, c = d_3.de/|e|, by

    xi = (-b + b c + a dtheta/2, a - a c + b dtheta/2, dtheta)
"""

from __future__ import annotations

from derod.algebra.jit import inlined, kernel
from derod.rod.angle import over_sine
from derod.rod.frames import fill_relative, fill_rows


@kernel
def clear_second(frames):
    """Set to zero what terms add to."""
    if frames is None:
        return
    frames.own[:] = 0.0
    frames.next[:] = 0.0
    frames.menisci[:] = 0.0


@kernel
def add_second(kin, hess, frames):
    """Add to the edge form what terms have added by strains, and what their slopes' changes cost."""
    if frames is None:
        return
    n = kin.rest.size - 2
    for i in range(n + 1):
        fill_relative(kin.tangent, i, frames)
        fill_rows(frames)
        fill_curve(kin.fall[i], i, frames)
        fill_turns(kin, i, frames)
        fill_by_edges(i, frames)
        fill_block(i, frames)
        block, by = frames.block, frames.by_edges
        for j in range(4):
            for m in range(4):
                hess.edge[i, j, m] += block[j, m]
                hess.edge[i + 1, j, m] += block[4 + j, 4 + m]
                hess.vertex[i, j, m] += block[j, 4 + m]
            for s in range(2):
                for k in range(3):
                    force = frames.menisci[s, i, k]
                    hess.edge_menisci[s, i, j] += force * by[i, k, j]
                    hess.edge_menisci[s, i + 1, j] += force * by[i, k, 4 + j]
    for e in range(1, n + 1):
        add_across(e, hess, frames)
        add_turning(kin, e, hess, frames)


@inlined
def fill_curve(fall, i, frames):
    """Fill the second derivatives, by body rotations, of the strains times their forces."""
    q, rows, weights, curve = frames.relative, frames.rows, frames.weights, frames.curve
    g0, g1, g2 = frames.by_strain[0, i], frames.by_strain[1, i], frames.by_strain[2, i]
    f, by_fall, twice = over_sine(fall)
    s0, s1, s2 = q[2, 1] - q[1, 2], q[0, 2] - q[2, 0], q[1, 0] - q[0, 1]
    c = q[0, 0] + q[1, 1]
    square = c * c + s2 * s2
    bend = 0.5 * (g0 * s0 + g1 * s1)
    weights[0, 0] = weights[1, 1] = -g2 * s2 / square
    weights[2, 2] = -by_fall * bend
    weights[2, 1], weights[1, 2] = 0.5 * f * g0, -0.5 * f * g0
    weights[0, 2], weights[2, 0] = 0.5 * f * g1, -0.5 * f * g1
    weights[1, 0], weights[0, 1] = g2 * c / square, -g2 * c / square
    ss, sc = -2 * g2 * s2 * c / square**2, g2 * (s2 * s2 - c * c) / square**2
    for j in range(6):
        tilt = 0.5 * (g0 * rows[0, j] + g1 * rows[1, j])
        for m in range(6):
            entry = ss * (rows[2, j] * rows[2, m] - rows[3, j] * rows[3, m])
            entry += sc * (rows[2, j] * rows[3, m] + rows[3, j] * rows[2, m])
            entry += twice * bend * rows[4, j] * rows[4, m]
            entry -= by_fall * tilt * rows[4, m]
            entry -= by_fall * rows[4, j] * 0.5 * (g0 * rows[0, m] + g1 * rows[1, m])
            curve[j, m] = entry
    whole = 0.0
    for j in range(3):
        for m in range(3):
            whole += weights[j, m] * q[j, m]
    for a in range(3):
        a1, a2 = (a + 1) % 3, (a + 2) % 3
        curve[a, a] -= whole
        curve[3 + a, 3 + a] -= whole
        for b in range(3):
            b1, b2 = (b + 1) % 3, (b + 2) % 3
            for k in range(3):
                curve[a, b] += 0.5 * (weights[a, k] * q[b, k] + weights[b, k] * q[a, k])
                curve[3 + a, 3 + b] += 0.5 * (weights[k, a] * q[k, b] + weights[k, b] * q[k, a])
            entry = weights[a1, b1] * q[a2, b2] - weights[a1, b2] * q[a2, b1]
            entry += weights[a2, b2] * q[a1, b1] - weights[a2, b1] * q[a1, b2]
            curve[a, 3 + b] += entry
            curve[3 + b, a] += entry


@inlined
def fill_turns(kin, i, frames):
    """Fill the first-order body rotations of both frames by their edges and angles."""
    turns = frames.turns
    turns[:] = 0.0
    for side in range(2):
        e = i + side
        for k in range(3):
            turns[3 * side, 4 * side + k] = -kin.inverse[e] * frames.second[k, e]
            turns[3 * side + 1, 4 * side + k] = kin.inverse[e] * frames.first[k, e]
        turns[3 * side + 2, 4 * side + 3] = 1.0


@inlined
def fill_by_edges(i, frames):
    """Fill the strains' first derivatives by both edges and their angles."""
    for j in range(3):
        for m in range(8):
            total = 0.0
            first = 0 if m < 4 else 3
            for k in range(first, first + 3):
                total += frames.slope[i, j, k] * frames.turns[k, m]
            frames.by_edges[i, j, m] = total


@inlined
def fill_block(i, frames):
    """Fill the second derivatives of one vertex by both edges and their angles."""
    by, turns, curve, block = frames.by_edges, frames.turns, frames.curve, frames.block
    for j in range(8):
        row = 0 if j < 4 else 3
        for m in range(8):
            column = 0 if m < 4 else 3
            total = 0.0
            for a in range(3):
                for b in range(3):
                    total += by[i, a, j] * frames.own[i, a, b] * by[i, b, m]
                    total += turns[row + a, j] * curve[row + a, column + b] * turns[column + b, m]
            block[j, m] = total


@inlined
def add_across(e, hess, frames):
    """Add what couples the strains before and behind an edge: of three edges and their angles."""
    by = frames.by_edges
    for j in range(8):
        for m in range(8):
            total = 0.0
            for a in range(3):
                for b in range(3):
                    total += by[e - 1, a, j] * frames.next[e, a, b] * by[e, b, m]
            if j < 4 and m < 4:
                hess.vertex[e - 1, j, m] += total
            elif j < 4:
                hess.skip[e, j, m - 4] += total
            elif m < 4:
                hess.edge[e, j - 4, m] += total
                hess.edge[e, m, j - 4] += total
            else:
                hess.vertex[e, j - 4, m - 4] += total


@inlined
def add_turning(kin, e, hess, frames):
    """Add the moment on an edge times the second-order turns of its frame."""
    one, two = frames.moment[e, 0] * kin.inverse[e], frames.moment[e, 1] * kin.inverse[e]
    for k in range(3):
        a_k, b_k, t_k = frames.first[k, e], frames.second[k, e], kin.tangent[k, e]
        across = 0.5 * (one * a_k + two * b_k)
        hess.edge[e, k, 3] += across
        hess.edge[e, 3, k] += across
        for m in range(3):
            a_m, b_m, t_m = frames.first[m, e], frames.second[m, e], kin.tangent[m, e]
            entry = one * (b_k * t_m + t_k * b_m) - two * (a_k * t_m + t_k * a_m)
            hess.edge[e, k, m] += kin.inverse[e] * entry
