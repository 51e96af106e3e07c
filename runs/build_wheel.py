"""Make a wheel that carries compiled kernels, for the Python that runs this.

    python runs/build_wheel.py [-o dist] [SCENE...]

Kernels of all kinds of pushes and of branches (or of the scenes' kinds) are compiled for the CPU x86-64-v3
into an empty cache, gathered with a manifest of what they fit, and put into a wheel of this Python's minor
version. It needs the packages that derod needs, and ``build``. ``python -m build`` by itself makes the
source distribution and a wheel without kernels.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import pickle
import platform
import shutil
import subprocess
import sys
import tempfile
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "derod"
CPU = "x86-64-v3"
FEATURES = (
    "64bit,avx,avx2,bmi,bmi2,cmov,crc32,cx16,cx8,f16c,fma,fxsr,lzcnt,mmx,movbe,popcnt,sahf,"
    "sse,sse2,sse3,sse4.1,sse4.2,ssse3,xsave"
)
"""Of x86-64-v3, by LLVM's names."""
MAGIC = (
    "import json; from numba.core.registry import cpu_target; "
    "print(json.dumps(cpu_target.target_context.codegen().magic_tuple()))"
)


def main() -> int:
    """Compile, gather and build."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("scenes", nargs="*", help="scene files; without, all kinds of pushes")
    parser.add_argument("-o", "--output", default="dist", help="folder of the wheel (dist)")
    args = parser.parse_args()
    if platform.machine() not in ("x86_64", "AMD64") or sys.platform != "linux":
        parser.error("kernels are shipped for x86-64 on Linux only; elsewhere they are compiled")
    sys.path.insert(0, str(ROOT))
    from derod.algebra.cache import sources_digest

    with tempfile.TemporaryDirectory(prefix="derod-wheel-") as folder:
        work = Path(folder)
        environment = build_environment(work)
        sources = sources_digest(PACKAGE)
        subprocess.run(
            [sys.executable, "-m", "derod", "warmup", *args.scenes], env=environment, check=True
        )
        kernels = gather(work, environment, args.scenes, sources)
        build(kernels, Path(args.output))
        sources_digest.cache_clear()
        if sources_digest(PACKAGE) != sources:
            raise SystemExit("the sources have changed meanwhile: do not use this wheel")
    return 0


def build_environment(work: Path) -> dict[str, str]:
    """The environment in which kernels are compiled: an empty cache, and the CPU."""
    kept = {name: value for name, value in os.environ.items() if not name.endswith("CACHE_DIR")}
    features = ",".join(f"+{name}" for name in FEATURES.split(","))
    return kept | {
        "PYTHONPATH": str(ROOT),
        "XDG_CACHE_HOME": str(work / "cache"),
        "NUMBA_CPU_NAME": CPU,
        "NUMBA_CPU_FEATURES": features,
        "DEROD_COMPILED": "no",
    }


def gather(work: Path, environment: dict[str, str], scenes: list[str], sources: str) -> Path:
    """Put the kernels of the cache in ``work`` into one folder, by the package's folders."""
    from derod.algebra import shipped
    from derod.cli.warmup import asked_for

    printed = subprocess.run(
        [sys.executable, "-c", MAGIC], env=environment, check=True, capture_output=True, text=True
    )
    magic = json.loads(printed.stdout)
    kernels = work / shipped.FOLDER
    files = {}
    (cache,) = (work / "cache" / "derod").glob("numba-*")
    for source in sorted({path.parent for path in PACKAGE.rglob("*.py")}):
        named = f"{source.name}_{hashlib.sha1(str(source).encode()).hexdigest()}"
        folder = source.relative_to(PACKAGE).as_posix()
        for path in sorted((cache / named).glob("*.nb[ic]")):
            target = kernels / folder / path.name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, target)
            files[f"{folder}/{path.name}"] = shipped.file_digest(path.read_bytes())
            if path.suffix == ".nbi":
                check_index(path, tuple(magic))
    if not files:
        raise SystemExit(f"no kernels in {cache}")
    manifest = {
        "format": shipped.FORMAT,
        "numba": metadata.version("numba"),
        "python": shipped.python_minor(),
        "sources": sources,
        "magic": magic,
        "variants": [variant.name for variant in asked_for(scenes)],
        "files": files,
    }
    (kernels / shipped.MANIFEST).write_text(json.dumps(manifest, indent=1))
    size = sum((kernels / name).stat().st_size for name in files)
    print(f"{len(files)} files of kernels, {size / 1e6:.1f} MB", flush=True)
    return kernels


def check_index(path: Path, magic: tuple[str, ...]) -> None:
    """Raise SystemExit if an index holds a kernel for another machine than the one asked for."""
    with path.open("rb") as file:
        pickle.load(file)
        _, overloads = pickle.loads(file.read())
    for _, made, _ in overloads:
        if made != magic:
            raise SystemExit(f"{path.name} holds a kernel for {made[1]}, not for {magic[1]}")


def build(kernels: Path, output: Path) -> None:
    """Build the wheel."""
    version = f"cp{sys.version_info[0]}{sys.version_info[1]}"
    tag = f"{version}-{version}{getattr(sys, 'abiflags', '')}-manylinux_2_17_x86_64"
    environment = os.environ | {"DEROD_KERNELS_TO_SHIP": str(kernels), "DEROD_KERNELS_TAG": tag}
    subprocess.run(
        [sys.executable, "-m", "build", "--wheel", "--outdir", str(output), str(ROOT)],
        env=environment,
        check=True,
    )


if __name__ == "__main__":
    sys.exit(main())
