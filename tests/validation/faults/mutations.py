"""Scenes and values of every kind: accepted, or refused in one line, at once."""

from __future__ import annotations

import contextlib
import io
import math
import random
import time
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

import derod
from derod import cli
from derod.errors import DerodError
from derod.scene.rules import KEYS
from tests.scenes import coil
from tests.validation.faults.trial import Found

MOST_CPU = 0.5  # s
WORDS = [
    "nan", "inf", "-inf", "1e-300", "1e308", "-1", "0", "0.0", "-0.0", "true", "''", "[]", "{}", '"2.8 pi"',
    '"pi pi"', "1e-16", "9" * 400, "[1, 2]", "[[1]]", "1979-05-27", '"\\u001b[2J"', '"\\u202e"', "0x7f",
    "100000", "12", "11", "1e9", "3", "2", '"fire"', '["0.1 pi", "0.1 pi"]', "5e-324", '"1/0"', "1e6",
]  # fmt: skip


def mutated(text: str, chance: random.Random) -> bytes:
    """A scene with some of its values, lines or bytes changed."""
    lines = text.splitlines()
    for _ in range(chance.choice((1, 1, 1, 2, 5))):
        place = chance.randrange(len(lines))
        line, way = lines[place], chance.randrange(7)
        if way <= 2 and "=" in line:
            lines[place] = f"{line.partition('=')[0]}= {chance.choice(WORDS)}"
        elif way == 3:
            lines.insert(place, chance.choice(lines))
        elif way == 4:
            del lines[place]
            lines = lines or ["x = 1"]
        elif way == 5:
            lines[place] = line[: chance.randrange(len(line) + 1)]
        else:
            odd = chance.choice(
                ("\x1b[31m", "\u202e", "\x00", "k" * 3000, "[", '"""', "a." * 500, "=")
            )
            at = chance.randrange(len(line) + 1)
            lines[place] = line[:at] + odd + line[at:]
    data = ("\ufeff" if chance.random() < 0.05 else "").encode() + "\n".join(lines).encode()
    if chance.random() < 0.1:
        place = chance.randrange(len(data))
        data = data[:place] + chance.randbytes(chance.randrange(4)) + data[place + 1 :]
    return data


def mutated_scenes(folder: Path, trials: int) -> Found:
    """``derod check`` of mutated scenes, in this process: exit code, lines, CPU time."""
    found, chance = Found("mutated scenes, `check`"), random.Random(21)
    text = coil(at='["0.1 pi", 0.2]').text
    path = folder / "scene.toml"
    for number in range(trials):
        data = mutated(text, chance)
        path.write_bytes(data)
        out, err = io.StringIO(), io.StringIO()
        began = time.process_time()
        try:
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                code = cli.main(["check", str(path)])
        except BaseException as error:
            found.fail(f"{number}: {type(error).__name__}: {error}: {data[:200]!r}")
            found.add("traceback")
            continue
        seconds = time.process_time() - began
        found.add({0: "accepted", 2: "refused"}.get(code, f"exit code {code}"), seconds)
        said = err.getvalue()
        lines_right = said == "" if code == 0 else said.count("\n") == 1
        if code not in (0, 2) or not lines_right or not said.replace("\n", "").isprintable():
            found.fail(f"{number}: exit code {code}: {said!r}")
        if seconds > MOST_CPU:
            found.fail(f"{number}: {seconds:.2f} s of CPU: {data[:200]!r}")
    return found


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20) | st.binary(max_size=9)
    | st.complex_numbers() | st.dates() | st.decimals() | st.fractions()
    | st.sampled_from([np.float32(1), np.int64(3), np.nan, np.array(2.0), np.zeros((2, 2)), object(), len,
                       np.array([0.1, 0.2]), np.datetime64("2001-01-01"), float("inf"), 10**400]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
    | st.tuples(inner, inner),
    max_leaves=6,
)  # fmt: skip
NAMES = st.sampled_from(
    [f"{table}.{name}" for table, keys in KEYS.items() for name in keys] + list(KEYS)
) | st.text(max_size=12)


def values(folder: Path, trials: int) -> Found:
    """``Scene.replace`` and ``parse_scene`` with values of any type."""
    found = Found("API values of any type, `Scene.replace`, `build_scene`, `parse_scene`")
    base = coil(edges=24)

    @seed(22)
    @settings(
        max_examples=trials,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(
        st.dictionaries(NAMES, VALUES, max_size=3), st.sampled_from(["replace", "build", "parse"])
    )
    def each(changes: dict[str, Any], way: str) -> None:
        began = time.process_time()
        try:
            if way == "replace":
                scene = base.replace(changes)
            elif way == "build":
                scene = derod.scene.build_scene(changes)
            else:
                scene = derod.parse_scene(next(iter(changes.values()), None))
            outcome = (
                "accepted" if derod.parse_scene(scene.text) == scene else "not what is written"
            )
        except DerodError as error:
            outcome = "refused" if str(error).isprintable() else "refused in more than a line"
        except Exception as error:
            outcome = f"{type(error).__name__}: {error}"
        seconds = time.process_time() - began
        found.add(outcome, seconds)
        if outcome not in ("accepted", "refused") or seconds > MOST_CPU:
            found.fail(f"{way} {changes!r}: {outcome}, {seconds:.2f} s")

    each()
    return found


def pushes(folder: Path, trials: int) -> Found:
    """Pushes of a few rows with values at the ends of what is allowed: an outcome, no traceback."""
    found, chance = Found("pushes at the ends of what scenes may say"), random.Random(23)
    base = coil(edges=24, stop='"0.01 pi"')
    ends = {
        "rod.bending": (1e-12, 1e9), "rod.twisting": (0.0, 1e9), "drop.capillary_force": (1e-12, 1e9),
        "drop.wall_strength": (1e-12, 1e9), "drop.wall_softness": (1e-12, 1.0), "rod.length": (1.1, 1e6),
        "noise.amplitude": (0.0, 1.0), "relax.tolerance": (1e-15, 1e-2), "mesh.layer": (0.01, 1e3),
        "mesh.inner_grading": (0.0, 3.0), "mesh.wetted_share": (0.3, 0.8), "mesh.edges": (12, 13),
        "clamps.end_rotation": (-1e6, 1e6), "push.start": (1e-300, 0.02), "push.max_step": (0.01, 1e6),
    }  # fmt: skip
    for _ in range(trials):
        names = chance.sample(sorted(ends), chance.choice((1, 2, 3)))
        changes = {name: chance.choice(ends[name]) for name in names}
        began = time.monotonic()
        try:
            run = derod.push(base.replace(changes))
            outcome = str(run.outcome)
            ending = run.ending
            if ending is None or (not math.isfinite(ending.end_shortening) and len(run)):
                found.fail(f"{changes}: ended at {ending}")
        except DerodError:
            outcome = "refused"
        except Exception as error:
            outcome = "traceback"
            found.fail(f"{changes}: {type(error).__name__}: {error}")
        found.add(outcome, time.monotonic() - began)
    return found
