"""The Hessian's edge form as a bordered band matrix in the layout of ``rod.unknowns``.

Row N of q is prescribed by the clamp: its positions keep unit rows, but for the axial one where the end
slides under a dead load.
"""

from __future__ import annotations

from derod.algebra.jit import inlined, kernel
from derod.rod.unknowns import BORDER, F_A, MOMENT, TURN, X_C

DEFLATION = 1e-4  # keeps the turn's row regular where the rod is straight


@inlined
def fill_band(physics, hess, band):
    """Turn the edge form into the lower diagonals of K, unknown w(i-1)+k being q[i, k]."""
    d, w = len(physics.axis), len(physics.row)
    n = hess.node.shape[0] - 1
    band[:] = 0.0
    for i in range(1, n):  # free nodes
        for k in range(d):
            column = w * (i - 1) + k
            for m in range(d):
                if m >= k:
                    band[column, m - k] = (
                        hess.edge[i, m, k]
                        + hess.edge[i + 1, m, k]
                        - hess.vertex[i, m, k]
                        - hess.vertex[i, k, m]
                        + hess.node[i, m, k]
                    )
                if i + 1 < n:
                    band[column, w + m - k] = (
                        -hess.edge[i + 1, m, k]
                        + hess.vertex[i, k, m]
                        + hess.vertex[i + 1, k, m]
                        - hess.skip[i + 1, k, m]
                    )
                if i + 2 < n:
                    band[column, 2 * w + m - k] = (
                        -hess.vertex[i + 1, k, m] + hess.skip[i + 1, k, m] + hess.skip[i + 2, k, m]
                    )
                if i + 3 < n:
                    band[column, 3 * w + m - k] = -hess.skip[i + 2, k, m]
    for k in range(d):
        band[w * (n - 1) + k, 0] = 1.0
    if w > d + 1:
        fill_angles(d, w, n, hess, band)
    for e in range(1, n + 1):  # tension rows
        row = w * (e - 1) + d
        for node in range(max(1, e - 2), min(n - 1, e + 1) + 1):
            slot = node - e + 2  # x_{e-2} ... x_{e+1}, by the edges e-1, e, e+1
            for k in range(d):
                value = 0.0
                if slot >= 1:
                    value += hess.constraint[e, slot - 1, k]
                if slot <= 2:
                    value -= hess.constraint[e, slot, k]
                column = w * (node - 1) + k
                band[min(row, column), abs(row - column)] = value


@inlined
def by_angle(d, n, edge, e, k, hess):
    """Return the second derivative by component k of ``edge`` and the angle of edge e."""
    if edge < 1 or edge > n:
        return 0.0
    if edge == e - 2:
        return hess.skip[e - 1, k, d]
    if edge == e - 1:
        return hess.vertex[e - 1, k, d]
    if edge == e:
        return hess.edge[e, k, d]
    if edge == e + 1:
        return hess.vertex[e, d, k]
    if edge == e + 2:
        return hess.skip[e + 1, d, k]
    return 0.0


@inlined
def fill_angles(d, w, n, hess, band):
    """Fill the rows of the angles: theta_e is unknown d + 1 of row e."""
    for e in range(1, n + 1):
        row = w * (e - 1) + d + 1
        band[row, 0] = hess.edge[e, d, d]
        if e < n:
            band[row, w] = hess.vertex[e, d, d]
        if e + 1 < n:
            band[row, 2 * w] = hess.skip[e + 1, d, d]
        for i in range(max(1, e - 3), min(n - 1, e + 2) + 1):
            for k in range(d):
                column = w * (i - 1) + k
                value = by_angle(d, n, i, e, k, hess) - by_angle(d, n, i + 1, e, k, hess)
                band[min(row, column), abs(row - column)] = value


@inlined
def fill_border(physics, q, b, turns_freely, room):
    """Fill the border columns and the corner."""
    d, w = len(physics.axis), len(physics.row)
    hess, kin = room.hess, room.kin
    linear = room.linear
    border, corner = linear.border, linear.corner
    n = q.shape[0] - 1
    border[:] = 0.0
    corner[:] = 0.0
    for k in range(BORDER + d):
        for m in range(BORDER + d):
            corner[k, m] = hess.border[k, m]
    for i in range(1, n + 1):
        for s in range(2):
            if i < n:
                for k in range(d):
                    border[w * (i - 1) + k, s] = (
                        hess.edge_menisci[s, i, k]
                        - hess.edge_menisci[s, i + 1, k]
                        + hess.node_menisci[s, i, k]
                    )
            border[w * (i - 1) + d, s] = hess.constraint_menisci[s, i]
            for k in range(d + 1, w):
                border[w * (i - 1) + k, s] = hess.edge_menisci[s, i, k - 1]
    for i in range(kin.node_a, kin.node_b + 1):  # moving the drop is moving the nodes back
        for k in range(d):
            row = w * (i - 1) + k
            for m in range(d):
                border[row, X_C + m] = -hess.node[i, k, m]
                corner[X_C + k, X_C + m] += hess.node[i, k, m]
            for s in range(2):
                corner[s, X_C + k] -= hess.node_menisci[s, i, k]
                corner[X_C + k, s] -= hess.node_menisci[s, i, k]
    for side in range(2 if physics.drop else 0):
        i = kin.node_a if side == 0 else kin.node_b
        for k in range(d):
            border[w * (i - 1) + k, F_A + d + side] = 2 * (q[i, k] - b[X_C + k])
    if d == 3:
        fill_twist(physics, room.grad, border, corner)
        fill_turn(w, kin, q, b, turns_freely, border, corner)
    if physics.slides:
        free_end(physics, hess, room.grad, linear)


@inlined
def fill_twist(physics, grad, border, corner):
    """Fill the twisting moment's row: k3/l grad psi grad psi, which is dense, with one unknown more."""
    moment = MOMENT + 3
    if physics.twisting == 0:
        corner[moment, moment] = -1.0
        return
    corner[moment, moment] = -physics.length / physics.twisting
    for i in range(1, grad.node.shape[0] - 1):
        for k in range(3):
            border[len(physics.row) * (i - 1) + k, moment] = (
                grad.holonomy[k, i] - grad.holonomy[k, i + 1]
            )


@inlined
def fill_turn(w, kin, q, b, neutral, border, corner):
    """Fill the row of the turn about the clamp axis: deflated where it is neutral, else idle."""
    turn = TURN + 3
    if not neutral:
        corner[turn, turn] = -1.0
        return
    square = 0.0
    for i in range(1, q.shape[0] - 1):
        row = w * (i - 1)
        dual = 0.5 * (kin.rest[i] + kin.rest[i + 1])
        border[row, turn] = -dual * q[i, 1]
        border[row + 1, turn] = dual * q[i, 0]
        square += dual * (q[i, 0] ** 2 + q[i, 1] ** 2)
    corner[X_C, turn] = -b[X_C + 1]
    corner[X_C + 1, turn] = b[X_C]
    corner[turn, X_C] = corner[X_C, turn]
    corner[turn, X_C + 1] = corner[X_C + 1, turn]
    square += b[X_C] ** 2 + b[X_C + 1] ** 2
    corner[turn, turn] = -(square + DEFLATION)


@inlined
def end_column(physics, hess, grad, column, border):
    """Fill the residual's derivative by z_N: ``column`` like the band's unknowns, ``border`` its rows.

    The row of z_N itself, for its own second derivative, is part of the column.
    """
    d, w = len(physics.axis), len(physics.row)
    n = hess.node.shape[0] - 1
    z = d - 1
    column[:] = 0.0
    border[:] = 0.0
    for k in range(d):
        near, next_one, last = (
            hess.vertex[n - 1, k, z],
            hess.skip[n - 1, k, z],
            w * (n - 2) + k,
        )
        column[last] = near - hess.edge[n, k, z]
        column[last - w] = next_one - near
        column[last - 2 * w] = -next_one
    column[w * (n - 1) + z] = hess.edge[n, z, z]
    column[w * (n - 1) + d] = hess.constraint[n, 1, z]
    column[w * (n - 2) + d] = hess.constraint[n - 1, 2, z]
    for e in range(n - 2, n + 1):
        for k in range(d + 1, w):
            column[w * (e - 1) + k] = by_angle(d, n, n, e, z, hess)
    for s in range(2):
        border[s] = hess.edge_menisci[s, n, z]
    if d == 3 and physics.twisting > 0:
        border[MOMENT + d] = grad.holonomy[z, n]


@inlined
def free_end(physics, hess, grad, linear):
    """Let the end clamp slide: give z_N its row."""
    d, w = len(physics.axis), len(physics.row)
    n = hess.node.shape[0] - 1
    end = w * (n - 1) + d - 1
    linear.band[end, 0] = hess.edge[n, d - 1, d - 1]
    linear.band[end, 1] = hess.constraint[n, 1, d - 1]
    linear.band[end - w + 1, w - 1] = hess.constraint[n - 1, 2, d - 1]
    for k in range(d):
        near, next_one = hess.vertex[n - 1, k, d - 1], hess.skip[n - 1, k, d - 1]
        last = w * (n - 2) + k
        linear.band[last, end - last] = near - hess.edge[n, k, d - 1]
        linear.band[last - w, end - last + w] = next_one - near
        linear.band[last - 2 * w, end - last + 2 * w] = -next_one
    for e in range(n - 2, n + 1):
        for k in range(d + 1, w):
            row = w * (e - 1) + k
            linear.band[min(row, end), abs(row - end)] = by_angle(d, n, n, e, d - 1, hess)
    for s in range(2):
        linear.border[end, s] = hess.edge_menisci[s, n, d - 1]
    if d == 3 and physics.twisting > 0:
        linear.border[end, MOMENT + d] = grad.holonomy[d - 1, n]


@kernel
def fill_end_column(physics, room, column, border):
    """Fill the derivative of the residual by z_N, as ``end_column``, from the Hessian filled last."""
    end_column(physics, room.hess, room.grad, column, border)
