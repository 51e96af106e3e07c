"""``derod push`` on a disk that is full at BYTES: ``... limited BYTES SCENE FILE``."""

import sys

from derod.cli import main
from tests.validation.faults.kills import limit_files

if __name__ == "__main__":
    import derod.pushing.driver  # noqa: F401  kernels are compiled and kept before the disk is full

    limit_files(int(sys.argv[1]))
    sys.exit(main(["push", sys.argv[2], "-o", sys.argv[3], "--quiet"]))
