"""HDF5 files of ours and of strangers: read in bounded time and memory, and held against checksums.

Run files and branch files share this, and nothing else.
"""

from derod.files import checks, digest
from derod.files.gate import Gate, open_gate, reason

__all__ = ["Gate", "checks", "digest", "open_gate", "reason"]
