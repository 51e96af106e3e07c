"""``derod fit``: values of a scene from a measured curve of force against displacement."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path
from typing import Any

from derod import exits, scenes
from derod.terminal import say, say_done, show
from derod.views import file_kinds as kinds

ENDINGS = ("toml", "json")


def add_fit_parser(commands: Any) -> None:
    """``derod fit DATA.csv SCENE --free KEYS``."""
    parser = commands.add_parser(
        "fit",
        help="fit keys of a scene to measured forces against displacements",
        description="Fit keys of SCENE to the curve of DATA, a CSV table with a header such as "
        "'displacement [mm],force [uN],error [uN]' or 'end_shortening,end_tension', by least squares on "
        "pushes. Exit code 3 where the fit does not converge, or the data do not determine a value.",
    )
    parser.add_argument("data", metavar="DATA", help="measured table (CSV)")
    parser.add_argument("scene", metavar="SCENE", help="scene file (TOML), or a shipped one")
    parser.add_argument(
        "--free", required=True, metavar="KEYS",
        help="what is fitted, e.g. drop.capillary_force,rod.bending; it starts at the scene's values",
    )  # fmt: skip
    parser.add_argument("--edges", type=int, metavar="N", help="edges of the discrete rod")
    parser.add_argument(
        "-o", "--output", metavar="OUT",
        help=".toml or .json to write (DATA-fit.toml); the table of residuals goes to .csv beside it",
    )  # fmt: skip
    parser.add_argument("--plot", metavar="OUT", help="picture to write: .png, .pdf or .svg")
    parser.add_argument("--scene-out", metavar="OUT", help="write the fitted scene (TOML)")
    parser.add_argument("--force", action="store_true", help="replace files that exist")
    parser.add_argument("--quiet", action="store_true", help="show nothing but errors")
    parser.set_defaults(command=run_fit, writes=True)


def run_fit(args: argparse.Namespace) -> int:
    """Carry out ``derod fit``."""
    from derod.fits.data import read_data
    from derod.fits.solving import check_data, fit, starting_values
    from derod.fits.writing import as_json, as_table, as_toml, told
    from derod.views.export.output import write_file

    kinds.expect(scenes.file_of(args.scene), kinds.SCENES, "SCENE")
    outputs = _outputs(args)
    scene = scenes.read_scene(args.scene)
    if args.edges is not None:
        scene = scene.replace({"mesh.edges": args.edges})
    data = read_data(args.data)
    free = [key.strip() for key in args.free.split(",") if key.strip()]
    starting_values(scene, free)
    check_data(data, scene, free)
    if not args.quiet:
        say(
            f"{args.data}: {len(data)} rows, {data.gaps} gaps; fitting {', '.join(free)}; loading kernels"
        )
    from derod.cli.compiling import kernels_ready

    with kernels_ready(scene, quiet=args.quiet):
        result = fit(data, scene, free)
    text = as_json(result) if outputs["result"].suffix == ".json" else as_toml(result)
    write_file(outputs["result"], text.encode(), args.force)
    write_file(outputs["table"], as_table(result).encode(), args.force)
    if "scene" in outputs:
        write_file(outputs["scene"], result.scene.text.encode(), args.force)
    if "plot" in outputs:
        from derod.views.plots.fitted import write_fit

        write_fit(result, outputs["plot"], args.force)
    for line in result.warnings:
        say(f"derod: warning: {line}")
    if not args.quiet:
        for line in told(result):
            show(line)
        say_done(f"written: {', '.join(shlex.quote(str(path)) for path in outputs.values())}")
    if not result.converged:
        say(f"derod: the fit did not converge: {result.message}")
    return exits.DONE if result.converged and not result.warnings else exits.NOT_REACHED


def _outputs(args: argparse.Namespace) -> dict[str, Path]:
    """The files to write, looked at before any work."""
    from derod.files.outputs import check_output
    from derod.views.export.output import check_target
    from derod.views.plots.options import ENDINGS as PICTURES

    data = Path(args.data)
    result = Path(args.output) if args.output else data.with_name(f"{data.stem}-fit.toml")
    check_target(result, args.force, ENDINGS)
    found = {"result": result, "table": result.with_suffix(".csv")}
    if args.scene_out:
        found["scene"] = Path(args.scene_out)
        check_target(found["scene"], args.force, ("toml",), "--scene-out")
    if args.plot:
        from derod.views.plots.kinds import need_matplotlib

        found["plot"] = Path(args.plot)
        check_target(found["plot"], args.force, PICTURES, "--plot")
        need_matplotlib()
    inputs = (args.data, scenes.file_of(args.scene))
    for name, path in found.items():
        others = [other for key, other in found.items() if key != name]
        check_output(path, force=args.force, inputs=inputs, others=others, make_folders=False)
    return found
