"""The orthogonal elimination against dense linear algebra."""

import numpy as np

from derod.branches.half_rod.chain import expand_chain, reduce_chain

ALL = np.arange(10)
INPUTS = np.arange(10, 14)


def random_chain(rng, count):
    A = rng.normal(size=(count, 10, 14))
    return A, rng.normal(size=(count, 10))


def dense(A, r, count):
    """The chain as one matrix: columns Y_0 ... Y_count, p; right-hand side -r."""
    matrix = np.zeros((10 * count, 10 * (count + 1) + 4))
    for e in range(count):
        own = slice(10 * e, 10 * e + 10)
        matrix[own, 10 * e : 10 * e + 10] = A[e, :, :10]
        matrix[own, 10 * e + 10 : 10 * e + 20] = -np.eye(10)
        matrix[own, -4:] = A[e, :, 10:]
    return matrix, -r.ravel()


def test_elimination_and_back_substitution(rng):
    count = 20
    A, r = random_chain(rng, count)
    out, kept = np.empty((10, 25)), np.zeros((count, 10, 35))
    ends = np.zeros(count, dtype=np.int64)
    reduce_chain(A, r, 0, count, ALL, INPUTS, out, kept, ends)
    first, dp = rng.normal(size=10), rng.normal(size=4)
    last = np.linalg.solve(out[:, 10:20], out[:, 24] - out[:, :10] @ first - out[:, 20:24] @ dp)
    nodes = np.zeros((count + 1, 10))
    nodes[0], nodes[-1] = first, last
    expand_chain(kept, ends, A, r, 0, count, 0, ALL, INPUTS, dp, 1.0, nodes)
    assert len(set(ends[ends > 0])) >= 3  # several groups, some of several elements
    assert (ends[ends > 0] - np.flatnonzero(ends)).max() > 1
    for e in range(count):
        missing = A[e, :, :10] @ nodes[e] + A[e, :, 10:] @ dp - nodes[e + 1] + r[e]
        assert np.abs(missing).max() < 1e-10 * np.abs(nodes).max()


def test_sign_of_the_determinant(rng):
    """The reduced block with the flips has the sign of the whole matrix closed by the same rows."""
    rows = np.array([1, 2, 4])
    none = np.array([], dtype=np.int64)
    for count in (1, 2, 5, 6):
        for _ in range(10):
            A, r = random_chain(rng, count)
            closing = rng.normal(size=(3, 6))
            out, kept = np.empty((3, 7)), np.zeros((count, 3, 10))
            ends = np.zeros(count, dtype=np.int64)
            flip = reduce_chain(A, r, 0, count, rows, none, out, kept, ends)
            small = np.vstack([out[:, :6], closing])
            size = 3 * (count + 1)
            whole = np.zeros((size, size))
            for e in range(count):
                block = A[e][np.ix_(rows, rows)]
                whole[3 * e : 3 * e + 3, 3 * e : 3 * e + 3] = block
                whole[3 * e : 3 * e + 3, 3 * e + 3 : 3 * e + 6] = -np.eye(3)
            whole[-3:, :3], whole[-3:, -3:] = closing[:, :3], closing[:, 3:]
            # columns Y_1..Y_{N-1} are eliminated in order, ahead of Y_0
            order = np.concatenate([np.arange(3, size - 3), [0, 1, 2], np.arange(size - 3, size)])
            sign = np.sign(np.linalg.det(whole[:, order]))
            assert sign == np.sign(np.linalg.det(small)) * (-1.0 if flip else 1.0), count


def test_growth_does_not_spoil_the_elimination():
    """exp(+-40) along the chain: transfer matrices lose all digits, the elimination none."""
    count = 40
    A = np.zeros((count, 10, 14))
    A[:, :, :10] = np.eye(10)
    A[:, 0, 0], A[:, 1, 1] = np.e, 1.0 / np.e
    turn = np.eye(10)
    turn[:2, :2] = [[0.8, -0.6], [0.6, 0.8]]
    A[:, :, :10] = turn @ A[:, :, :10] @ turn.T
    out, kept = np.empty((10, 25)), np.zeros((count, 10, 35))
    ends = np.zeros(count, dtype=np.int64)
    zero = np.zeros((count, 10))
    reduce_chain(A, zero, 0, count, ALL, INPUTS, out, kept, ends)
    nodes = np.zeros((count + 1, 10))
    # grow from 1 at the far end, decay from 1 at the near end
    near, far = turn[:, 1], turn[:, 0]
    nodes[0] = near + np.exp(-40.0) * far
    nodes[-1] = far + np.exp(-40.0) * near
    expand_chain(kept, ends, A, zero, 0, count, 0, ALL, INPUTS, np.zeros(4), 0.0, nodes)
    i = np.arange(count + 1)
    exact = np.exp(-1.0 * i)[:, None] * near + np.exp(i - 40.0)[:, None] * far
    assert np.abs(nodes - exact).max() < 1e-12
