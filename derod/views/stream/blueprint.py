"""What a viewer shows when it opens: nothing to arrange by hand."""

from __future__ import annotations

from typing import Any

import rerun.blueprint as rrb

from derod.views.stream.legend import HEIGHT, WIDTH

EYE = (1.72, 0.62, -0.72)  # D, from the drop's centre
NIGHT = (18, 20, 26)


def run_blueprint(*, live: bool) -> Any:
    """The drop in the middle of a 3D view with its key below, the curves and the events beside it.

    Curves run along the timeline that is chosen: δ in D, which rerun writes as seconds, or increments.
    """
    space = rrb.Spatial3DView(
        origin="world/drop",
        contents="world/**",
        name="rod and drop",
        background=NIGHT,
        line_grid=False,
        eye_controls=rrb.EyeControls3D(
            kind="Orbital", position=EYE, look_target=(0.0, 0.0, 0.0), eye_up=(0.0, 1.0, 0.0)
        ),
    )
    legend = rrb.Spatial2DView(
        origin="legend",
        name="colours and arrows",
        background=NIGHT,
        visual_bounds=rrb.VisualBounds2D(x_range=(0.0, WIDTH), y_range=(0.0, HEIGHT)),
    )
    curves = rrb.Vertical(
        _series("tension t, K0/D²", "plots/tension"),
        _series("energies, K0/D", "plots/energy"),
        rrb.Tabs(
            _series("wetted length", "plots/wetted_length"),
            _series("unstable modes", "plots/unstable_modes"),
            _series("residual", "plots/residual"),
            _series("relaxation", "plots/relaxation"),
            rrb.TextDocumentView(origin="about", name="what is shown"),
        ),
        rrb.TextLogView(origin="events", name="events"),
        row_shares=[3, 4, 3, 2],
    )
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(space, legend, row_shares=[6, 1]), curves, column_shares=[3, 2]
        ),
        _time("end_shortening", live=live),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        auto_layout=False,
        auto_views=False,
    )


def branch_blueprint(names: list[str]) -> Any:
    """All paths of a branch file in one 3D view, and their tension and energy."""
    space = rrb.Spatial3DView(
        origin="world/drop",
        contents=["+ world/**"],
        name="branches: " + ", ".join(names),
        background=NIGHT,
        line_grid=False,
        eye_controls=rrb.EyeControls3D(
            kind="Orbital", position=EYE, look_target=(0.0, 0.0, 0.0), eye_up=(0.0, 1.0, 0.0)
        ),
    )
    curves = rrb.Vertical(
        _series("tension t, K0/D²", "branches/tension", (-2.0, 26.0)),
        _series("energy Ê, K0/D", "branches/energy_hat", (0.0, 50.0)),
        rrb.TextLogView(origin="events", name="bifurcations"),
        row_shares=[3, 3, 2],
    )
    return rrb.Blueprint(
        rrb.Horizontal(space, curves, column_shares=[3, 2]),
        _time("end_shortening", live=False),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        auto_layout=False,
        auto_views=False,
    )


def _series(name: str, origin: str, values: tuple[float, float] | None = None) -> Any:
    return rrb.TimeSeriesView(
        origin=origin,
        name=name,
        plot_legend=rrb.PlotLegend(visible=origin in ("plots/energy", "plots/wetted_length")),
        axis_y=None if values is None else rrb.ScalarAxis(range=values),
    )


def _time(timeline: str, *, live: bool) -> Any:
    return rrb.TimePanel(
        state="collapsed",
        timeline=timeline,
        play_state="following" if live else "playing",
        loop_mode=None if live else "all",
    )
