"""Whether two branch files hold the same branches, bit for bit.

    python runs/branch_identity.py BEFORE.h5 AFTER.h5 [BEFORE AFTER ...]

Compares names, t, E_hat and every other column of the tables, special points, node states and meshes.
Prints one line a branch; exit code 1 where anything differs. For changes that must not change numbers:
write both files by ``derod branch SCENE -o FILE``, one with the code before.
"""

from __future__ import annotations

import sys

import numpy as np

from derod.branches.files.record import BranchFile, open_branches


def differences(before: BranchFile, after: BranchFile) -> list[str]:
    """What differs, one line each; prints one line a branch."""
    out = []
    if before.names != after.names:
        out.append(f"names: {before.names} and {after.names}")
    for name in before.names:
        if name not in after:
            continue
        a, b = before[name], after[name]
        same = [
            column
            for column in a.table.dtype.names or ()
            if np.array_equal(a.table[column], b.table[column], equal_nan=column == "error")
        ]
        other = [column for column in a.table.dtype.names or () if column not in same]
        other += [
            part
            for part in ("bifurcations", "all_nodes", "all_eta")
            if not np.array_equal(getattr(a, part), getattr(b, part))
        ]
        print(f"{name:8s} {len(a):4d} points: {', '.join(other) or 'the same'}")
        out += [f"{name}: {one}" for one in other]
    return out


def main() -> int:
    """Compare the files named on the command line, two by two."""
    files = sys.argv[1:]
    if not files or len(files) % 2:
        print(__doc__)
        return 2
    found = []
    for first, second in zip(files[::2], files[1::2], strict=True):
        print(first, second)
        with open_branches(first) as before, open_branches(second) as after:
            found += differences(before, after)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
