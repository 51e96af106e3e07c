"""Puts compiled kernels into a wheel where ``runs/build_wheel.py`` has made some; else it is a pure one."""

from __future__ import annotations

import os
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

KERNELS = "DEROD_KERNELS_TO_SHIP"  # a folder of kernels with their manifest
TAG = "DEROD_KERNELS_TAG"  # Python, ABI and platform that they are for


class CompiledKernels(BuildHookInterface):
    """A hook of hatchling's."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the folder, and make the wheel one for its Python and platform."""
        folder = os.environ.get(KERNELS)
        if not folder or self.target_name != "wheel" or version == "editable":
            return
        build_data["force_include"][folder] = "derod/compiled"
        build_data["pure_python"] = False
        build_data["tag"] = os.environ[TAG]
