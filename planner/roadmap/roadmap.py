"""The roadmap: the diagram's chains as a graph with exact clearances, and plans on it.

Everything is in the scene's units. The clearance of a place is its exact distance to the nearest
border or wall of the bounds, negative inside an obstacle or outside the bounds.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from planner.borders import box_tree_kernels
from planner.borders.generators import (
    Borders,
    HasPrimitives,
    Mode,
    choose_spacing,
    count_generators,
    gather_borders,
    place_generators,
)
from planner.diagram.agvd import (
    Agvd,
    Chains,
    join_chains,
    mesh_chains,
    omit_invalid,
    solve_chains,
)
from planner.diagram.mesh import make_mesh
from planner.path import NoPath, Path
from planner.roadmap.clip import Clipped, clip_chains
from planner.route.no_way import Blocked, explain, walled_in
from planner.route.plan_request import Request
from planner.route.route import plan_request
from planner.scene import FloatArray, Scene, Vec
from planner.scene.drawing import ROAD, StyledLines, plot, to_svg
from planner.shared.arguments import as_numbers, as_positive, of_kind, one_of

if TYPE_CHECKING:
    import networkx as nx
    from matplotlib.axes import Axes


DENSER_BY = 4.0
"""Factor of density if the widest path is narrower than the generators' spacing."""
FINER_MOST = 200_000
"""Generators at most, which take about 0.2 s."""
NOT_FINER = "ways narrower than the generators' spacing were not looked for: the limit was reached"


@dataclass(frozen=True, slots=True)
class Clearance:
    """Least clearance of a polyline, its place, and the piece and object there.

    ``owner`` is the object's index in ``Scene.objects``, -1 for the bounds.
    """

    distance: float
    at: Vec
    piece: int
    owner: int


@dataclass(frozen=True, slots=True)
class Roadmap:
    """AGVD roadmap of a scene for a robot of ``radius``; see :func:`build_roadmap`."""

    radius: float
    spacing: float
    mode: Mode
    scene: HasPrimitives
    agvd: Agvd
    chains: Chains
    least_branch: float = 0.0
    _made: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)

    def __repr__(self) -> str:
        units = str(getattr(self.scene, "units", ""))
        radius = f"{self.radius:.6g} {units}".rstrip()
        return f"<Roadmap for radius {radius}, {len(self.chains)} chains of {self.scene!r}>"

    @property
    def borders(self) -> Borders:
        """Borders of the scene, indexed for distance queries."""
        return self.agvd.borders

    @property
    def clipped(self) -> Clipped:
        """Chains, cut where their clearance passes the radius."""
        if "clipped" not in self._made:
            self._made["clipped"] = clip_chains(self.borders, self.chains, self.radius)
        return self._made["clipped"]  # type: ignore[no-any-return]

    @property
    def kept(self) -> Sequence[int]:
        """Numbers of the clipped chains in the graph, ascending."""
        return self._shortened[0]

    @property
    def _shortened(self) -> tuple[Sequence[int], Sequence[float]]:
        if "shortened" not in self._made:
            from planner.roadmap.graph import without_short_branches, without_spurs

            kept = without_spurs(self.clipped, self.radius)
            left_out: tuple[float, ...] = ()
            if self.least_branch > 0.0:
                kept, left_out = without_short_branches(
                    self.clipped.chains, kept, self.radius, self.least_branch
                )
            self._made["shortened"] = tuple(kept), left_out
        return self._made["shortened"]  # type: ignore[no-any-return]

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences on objects that touch or coincide, and on an empty roadmap."""
        if "remarks" not in self._made:
            from planner.roadmap.remarks import remark_on_branches, remarks_on

            units = str(getattr(self.scene, "units", ""))
            remarks = remarks_on(self.borders, self.clipped, self.radius, units)
            if self.least_branch > 0.0:
                remarks += (remark_on_branches(self._shortened[1], self.least_branch, units),)
            self._made["remarks"] = remarks
        return self._made["remarks"]  # type: ignore[no-any-return]

    @property
    def counts(self) -> Mapping[str, int]:
        """generators, voronoi_vertices, roadmap_nodes, roadmap_edges."""
        from planner.roadmap.graph import count_graph

        generators, vertices = self.agvd.counts
        nodes, edges = count_graph(self.clipped.chains, self.kept)
        return {
            "generators": generators,
            "voronoi_vertices": vertices,
            "roadmap_nodes": nodes,
            "roadmap_edges": edges,
        }

    @property
    def graph(self) -> nx.Graph[int]:
        """Graph as a ``networkx.Graph``, made on demand.

        Nodes have ``pos`` (x, y), ``clearance`` and ``owners``; edges ``geometry``
        (:class:`planner.diagram.bisectors.Piece` in order), ``polyline`` (n, 2) through exact
        places, which leaves it by 5 % of the spacing at most, ``length`` (the polyline's),
        ``clearance`` (its minimum, exact, never below the radius; the polyline's is at most 1e-4
        less) and ``owners``.
        """
        if "graph" not in self._made:
            from planner.roadmap.graph import make_graph

            self._made["graph"] = make_graph(
                self.clipped.chains, self.kept, self.borders, self.radius, self.spacing
            )
        return self._made["graph"]  # type: ignore[no-any-return]

    def to_networkx(self) -> nx.Graph[int]:
        """Return the graph with numbers or text as attributes, for files and other programs.

        Nodes have ``x``, ``y``, ``clearance`` and ``owners`` ("0 2"), edges ``length``,
        ``clearance``, ``owners`` and ``polyline`` ("x,y x,y ..."), the graph ``radius``,
        ``spacing`` and ``units``. ``networkx.write_graphml`` accepts it.
        """
        from planner.roadmap.roadmap_export import to_networkx

        return to_networkx(self)

    def save(self, path: str | os.PathLike[str], *, frame: str = "map") -> None:
        """Write the graph as .graphml, .json, .geojson (Nav2), .lif (LIF) or .yaml (Open-RMF).

        ``frame`` is the frame of its coordinates, for all but the first two. Raises
        :class:`planner.graph_files.route_graph.ExchangeError` for another suffix or a file that
        cannot be written.
        """
        from planner.graph_files.route_graph import ExchangeError
        from planner.roadmap.roadmap_export import as_text

        if not isinstance(path, str | os.PathLike):
            raise TypeError(f"path is a {type(path).__name__}: must be the name of a file")
        file = FilePath(path)
        text = as_text(self, file.suffix, frame=frame)
        try:
            file.write_text(text, encoding="utf-8")
        except OSError as error:
            raise ExchangeError(f"{file}: {error.strerror or error}") from None

    def layers(self) -> list[StyledLines]:
        """Layers to draw: the scene, if it can be drawn, and the edges."""
        below = self.scene.layers() if isinstance(self.scene, Scene) else []
        lines = [data["polyline"] for _, _, data in self.graph.edges(data=True)]
        return [*below, StyledLines(lines, ROAD, 1.2)]

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw scene and roadmap on Matplotlib axes, by default the current ones; return them."""
        return plot(self.layers(), getattr(self.scene, "y_down", False), axes)

    def _repr_svg_(self) -> str | None:
        """Picture for a notebook; None if the scene cannot be drawn."""
        if not isinstance(self.scene, Scene):
            return None
        title = f"a roadmap for radius {self.radius:g}"
        return to_svg(title, self.layers(), self.scene.view, self.scene.y_down)

    def updated(self, scene: Scene) -> Roadmap:
        """Roadmap of a scene that differs by a few objects, much faster than from scratch.

        Finds the objects added, removed or moved, see :mod:`planner.diagram.update`.
        """
        from planner.diagram.update import update_diagram

        of_kind("scene", scene, Scene)
        agvd = None
        if isinstance(self.scene, Scene) and self.mode == "exact":
            agvd = update_diagram(self.agvd, self.scene, scene)
        if agvd is None or agvd.mesh is None:
            return build_roadmap(
                scene,
                self.radius,
                spacing=self.spacing,
                mode=self.mode,
                least_branch=self.least_branch,
            )
        chains = mesh_chains(agvd.mesh, agvd.borders, agvd.spacing)
        return replace(self, scene=scene, agvd=agvd, chains=chains, _made={})

    def clearance(self, points: ArrayLike) -> FloatArray:
        """Exact clearance of every point (n, 2), negative in obstacles and out of bounds.

        ``ValueError`` if a point is not finite.
        """
        return self.borders.signed_distances(_places("points", points))

    def path_clearance(self, polyline: ArrayLike) -> Clearance:
        """Least distance of a polyline (n, 2) to any border: exact, without sampling."""
        xy = _places("polyline", polyline)
        if not len(xy):
            raise ValueError("polyline: must have at least one point")
        gap, x, y, piece, which = box_tree_kernels.polyline_clearance(self.borders.tree, xy)
        return Clearance(gap, (x, y), piece, int(self.borders.owner[which]))

    def permits(self, _polyline: FloatArray, _keep: float) -> bool:
        """Return True: a roadmap without zones forbids nothing but nearness."""
        return True

    def plan(
        self,
        start: Sequence[float],
        goal: Sequence[float],
        *,
        prefer: str | float = "balanced",
        via: Sequence[Sequence[float]] = (),
        order: Literal["fixed", "best"] = "fixed",
        alternatives: int = 0,
        margin: float = 0.0,
        relaxed: bool = False,
        near: Path | NoPath | None = None,
    ) -> Path | NoPath:
        """Plan a path from start to goal for this roadmap's robot, or explain why there is none.

        Stations are (x, y) or (x, y, heading_rad), anywhere in free space. ``prefer`` is
        "clearance" (the widest path, along the middle; the cheapest of those equally wide within
        1e-9), "length" (the shortest that keeps the radius), "balanced", or a number from 0
        (length) to 1 (clearance). ``order`` "best" orders the stations so that the whole path is
        shortest, of legs planned as preferred; the goal stays last. A leg is the same in both
        directions. ``margin`` is added to the radius. No path comes nearer to a border than radius
        and margin; with ``relaxed``, a station within the margin is connected by a short straight
        line that keeps the radius, and a remark reports it. ``alternatives`` is the number of other
        paths, none a shift of another: the best, once taut, of the cheapest routes without a loop,
        at least twice as many. ``near`` is the last path, on which the robot is: while it is clear,
        and within 2 % as good as the best, the answer is its rest, so that noise does not make
        plans jump. Raises ``ValueError`` on invalid options.
        """
        if near is not None:
            of_kind("near", near, Path, NoPath)
        request = Request.of(start, goal, prefer, via, order, alternatives, margin, relaxed=relaxed)
        units = str(getattr(self.scene, "units", ""))
        answer = plan_request(
            self.borders,
            self.chains,
            self.radius,
            request,
            units,
            chains_only=self.mode == "paper",
            near=near,
            unknown=self.scene.unknown if isinstance(self.scene, Scene) else None,
        )
        if isinstance(answer, Blocked):
            return self._explain(answer, units)
        if isinstance(answer, Path) and isinstance(self.scene, Scene):
            return replace(answer, scene=self.scene)  # so that the path can show itself
        return answer

    def _finer(self) -> Roadmap:
        """Make the roadmap from denser generators, if narrow places decide a refusal.

        Between generators, paths narrower than their spacing look like walls.
        """
        if "finer" not in self._made:
            spacing = self.spacing / DENSER_BY
            self._made["finer"] = build_roadmap(
                self.scene, self.radius, spacing=spacing, mode=self.mode
            )
        return self._made["finer"]  # type: ignore[no-any-return]

    def _explain(self, blocked: Blocked, units: str) -> NoPath:
        """Report where the widest path is too narrow, or that no robot has one."""
        refusal = explain(self.borders, self.chains, blocked, self.radius, units)
        if refusal is not None and refusal.bottleneck and refusal.bottleneck.width >= self.spacing:
            return refusal
        if count_generators(self.borders, self.spacing / DENSER_BY) > FINER_MOST:
            if refusal is None:  # a refusal counts as False, too
                refusal = walled_in(blocked, self.spacing, units)
            return replace(refusal, remarks=(*refusal.remarks, NOT_FINER))
        finer = self._finer()
        refusal = explain(finer.borders, finer.chains, blocked, self.radius, units)
        return walled_in(blocked, finer.spacing, units) if refusal is None else refusal


def _places(name: str, points: ArrayLike) -> FloatArray:
    # a copy: numba would compile the kernels again for read-only arrays
    xy = as_numbers(name, points, "places (n, 2)")
    if xy.size == 0:
        return np.empty((0, 2))
    if xy.shape[-1:] != (2,) or xy.ndim > 2:
        raise ValueError(f"{name}: shape {xy.shape}: must be (n, 2)")
    xy = xy.reshape(-1, 2)
    if not np.isfinite(xy).all():
        at = int(np.flatnonzero(~np.isfinite(xy).all(axis=1))[0])
        raise ValueError(f"{name}[{at}] = {tuple(xy[at].tolist())}: must be finite")
    return xy


def build_roadmap(
    scene: HasPrimitives,
    radius: float,
    *,
    spacing: float | None = None,
    mode: Mode = "exact",
    least_branch: float = 0.0,
    lap: Callable[[str], None] | None = None,
) -> Roadmap:
    """Build the roadmap of a scene for a disc-like robot.

    ``radius`` > 0 and ``spacing`` < 2 radius (default: one radius) are in the scene's units;
    otherwise ``ValueError``. ``mode="paper"`` follows the paper's section 2.3.1 to the letter:
    edges between generators of one object are omitted. ``least_branch`` leaves shorter dead ends
    out of the graph, which a remark counts; loops and paths between two branches stay, and paths
    are planned as without it. ``lap`` is called with the name of each stage as it ends: geometry,
    voronoi, roadmap. O(n) on average for n generators.
    """
    if not hasattr(scene, "primitives"):
        of_kind("scene", scene, Scene)
    if not (lap is None or callable(lap)):
        raise TypeError(f"lap is a {type(lap).__name__}: must be a function")
    done = lap or (lambda stage: None)
    size = as_positive("radius", radius)
    delta = choose_spacing(size, spacing)
    one_of("mode", mode, "exact", "paper")
    least = as_positive("least_branch", least_branch, zero=True)
    borders = gather_borders(scene, mode)
    generators = place_generators(borders, delta)
    done("geometry")
    mesh = make_mesh(generators)
    done("voronoi")
    if mode == "exact":
        agvd, chains = solve_chains(mesh, generators)
    else:
        agvd = omit_invalid(mesh, generators, mode)
        chains = join_chains(agvd)
    roadmap = Roadmap(size, agvd.spacing, mode, scene, agvd, chains, least)
    done("roadmap")
    return roadmap
