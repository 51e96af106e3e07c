"""``python -m derod`` is the command ``derod``."""

import sys

from derod.cli import main

sys.exit(main())
