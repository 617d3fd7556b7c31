"""The paper's formulas and claims, one row each: where it lives, what holds it, what was found."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.paper.measured import Measured


@dataclass(frozen=True, slots=True)
class Claim:
    """One row. ``code`` is ``path::name``, ``test`` is ``path::test name``; ``found`` is what is
    wrong, weak or confirmed, ``instead`` what the default mode does, with the difference."""

    section: str
    claim: str
    code: str
    test: str
    found: str
    instead: str


VORONOI = "tests/planner/delaunay/test_voronoi.py"
ROADMAP = "tests/planner/roadmap/test_roadmap.py"
COMPLETE = "tests/planner/route/test_route_completeness.py"
PAPER = "tests/system/test_paper.py"


def claims(m: Measured) -> list[Claim]:
    """All rows, in the order of the paper."""
    return [*_diagrams(m), *_pictures(m), *_circles_and_records(m), *_costs(m), *_robot(m)]


def _diagrams(m: Measured) -> list[Claim]:
    return [
        Claim(
            "2.1, eq. 1",
            "The diagram of non-collinear points; V(P) is the union of all regions",
            "planner/delaunay/voronoi_diagram.py::voronoi",
            f"{VORONOI}::test_diagram_is_what_the_definition_says",
            "As written V(P) is the whole plane: the regions' borders are meant. Collinear,"
            " coincident and cocircular sites are left out, and pixels are just that",
            "any finite sites; ties decided exactly, edges without length flagged",
        ),
        Claim(
            "2.2, eq. 2-5",
            "Distance to a line, an arc, an area; L_i and L_j meet nowhere",
            "planner/borders/box_tree_kernels.py::distance",
            "tests/planner/borders/test_distance.py::test_nearest_border_is_as_far_as_numpy_says",
            "Section 2.2.1 says the intersection is *not* empty: a misprint. An area may have no"
            " hole (Euler number 1)",
            "touching, crossing and nested objects and holes are taken; distances in closed form",
        ),
        Claim(
            "2.3",
            "Insertion: walk the bisectors around the new site, remove what they enclose",
            "planner/delaunay/diagram_kernels.py::diagram",
            f"{PAPER}::test_the_papers_walk_gives_the_region_that_the_kernel_gives",
            f"{'Confirmed' if m.walk_agrees else 'Refuted'}: both give one region. The walk"
            " alone does not say what to do at ties, or where the region is unbounded",
            "the enclosed vertices are found first, as a tree (Sugihara and Iri's own rule)",
        ),
        Claim(
            "2.3, 5",
            "Stable against numerical errors",
            "planner/delaunay/diagram_kernels.py::certify",
            f"{VORONOI}::test_lying_arithmetic_cannot_break_the_topology",
            "Confirmed for the topology: even arithmetic that lies gives a valid graph. But a"
            " valid graph may be the wrong one",
            "doubtful signs are computed exactly, and `check()` proves each circle empty",
        ),
        Claim(
            "2.3.1",
            "Arcs and lines as points every delta; the edges that cross an object are invalid",
            "planner/diagram/agvd.py::omit_invalid",
            f"{ROADMAP}::test_paper_mode_omits_edges_within_one_object",
            '"Only edges of adjacent objects remain" also drops every edge into a U or into a'
            f" room of one wall: {_share_missed(m)} of pairs with a path are then not planned",
            "edges within one straight or round piece are dropped, all others kept; "
            f"{m.completeness['exact'].planned} of {m.completeness['exact'].joined} planned",
        ),
    ]


def _pictures(m: Measured) -> list[Claim]:
    calm, noisy = m.corners[0.0, "paper"], m.corners[20.0, "paper"]
    ours, ours_noisy = m.corners[0.0, "exact"], m.corners[20.0, "exact"]
    wide = max(m.protrusions[r, "paper"] for r, mode in m.protrusions if mode == "paper")
    tight = max(m.protrusions[r, "exact"] for r, mode in m.protrusions if mode == "exact")
    return [
        Claim(
            "3.1",
            "Threshold, then border pixels where the Laplacian M answers",
            "vision/borders/contours.py::laplacian_border",
            "tests/vision/borders/test_contours.py::test_the_walk_visits_exactly_the_pixels_of_the_papers_laplacian",
            "Confirmed; its pixels lie inside the object, so that records shrink by half a pixel"
            " and more",
            "edge points between the pixels, from the grey levels; the level is chosen from the"
            " picture",
        ),
        Claim(
            "3.1",
            "Follow contours clockwise, 8-connected",
            "vision/borders/contours.py::follow_borders",
            "tests/vision/borders/test_contours.py::test_outlines_run_clockwise_on_the_screen",
            "Confirmed; holes are not spoken of",
            "holes are followed too and belong to the object around them",
        ),
        Claim(
            "3.1, eq. 6-13",
            "lambda_S of the covariance over i - k .. i + k, k = 7",
            "vision/paper/corners.py::small_eigenvalues",
            "tests/vision/paper/test_corners.py::test_the_sliding_sums_are_the_covariance_of_equations_6_to_13",
            "The set S_k is written with 2 k pixels (to i + k - 1), the sums with 2 k + 1: the"
            " sums are right",
            "used as it is to seed corners in the paper's mode only",
        ),
        Claim(
            "3.1",
            "A corner where lambda_S > 0.1, at least k apart",
            "vision/paper/corners.py::find_corners",
            f"{PAPER}::test_the_threshold_lies_on_the_floor_of_digital_lines",
            f"0.1 lies on the floor: a perfect digital line reaches {m.line_floor:.4f}, and a"
            f" right angle {m.corner_values[90.0]:.2f}. {calm.false} false corners among"
            f" {calm.true} without noise, {noisy.false} at noise 20; rms {calm.rms_px:.2f} px",
            f"breaks by the residual of line and arc fits: {ours.false} false and"
            f" {ours_noisy.false} at noise 20, none missed; rms {ours.rms_px:.3f} px, and"
            f" {ours_noisy.rms_px:.2f} at noise 20",
        ),
        Claim(
            "3.1",
            "lambda_S / lambda_L is near 1 for circles (Tsai; the paper found it unreliable)",
            "benchmarks/paper/weaknesses.py::eigenvalue_ratio",
            f"{PAPER}::test_the_eigenvalue_ratio_does_not_tell_circles",
            "The paper is right, it tells nothing: "
            + ", ".join(f"{name} {value:.3f}" for name, value in m.ratios.items()),
            "not used; circles are fitted and judged by their residual",
        ),
        Claim(
            "3.1",
            "An arc is the polygonal line through its corner pixels",
            "vision/paper/paper.py::paper_objects",
            f"{PAPER}::test_arcs_of_the_papers_mode_cut_into_the_obstacle",
            f"The line lies inside the obstacle: its true edge stands out by up to {wide:.1f} px,"
            " on the side where a robot drives",
            f"arcs stay arcs, with centre and radius: at most {tight:.2f} px",
        ),
    ]


def _circles_and_records(m: Measured) -> list[Claim]:
    def taken(radius: float, noise: float) -> str:
        t = m.circles[radius, noise, "paper"]
        return f"{t.circles} of {t.shown}"

    eight, ours = m.octagons[8.0, "paper"], m.octagons[8.0, "exact"]
    error = max(t.radius_error_px for (_, _, mode), t in m.circles.items() if mode == "paper")
    our_error = max(t.radius_error_px for (_, _, mode), t in m.circles.items() if mode == "exact")
    every = [t for (_, _, mode), t in m.circles.items() if mode == "exact"]
    return [
        Claim(
            "3.2, eq. 14",
            "A closed digital curve is a circle if every pixel is within half a pixel in y",
            "vision/paper/circles.py::digital_circle",
            "tests/vision/paper/test_circles.py::test_sauers_test_takes_a_digital_disc_and_finds_its_centre",
            "The bound in y alone fails where the circle is steep: of perfect discs of 12 px"
            f" {m.literal_discs.circles} of {m.literal_discs.shown} pass; x and y must change"
            " places there. The threshold is not told (0.25 px here). Noise breaks it: of circles"
            f" of 30 px {taken(30.0, 0.0)} pass, at noise 5 {taken(30.0, 5.0)}, at 20"
            f" {taken(30.0, 20.0)}; octagons of 8 px pass, {eight.circles} of {eight.shown};"
            f" radii are up to {error:.2f} px short",
            f"all {sum(t.circles for t in every)} of {sum(t.shown for t in every)} found at noise"
            f" up to 20, radius within {our_error:.2f} px. Octagons of 8 px pass here too"
            f" ({ours.circles} of {ours.shown}, off by {ours.radius_error_px:.2f} px); from 12 px"
            " they do not",
        ),
        Claim(
            "3.3",
            "The records P, S, C, A, L",
            "planner/formats/scene_text.py::read_scene_text",
            "tests/planner/formats/test_scene_io.py::test_the_papers_five_records_are_read",
            "An L whose edges are arcs cannot be rebuilt from its vertices, as section 3.2"
            " promises: the format has no place for centre and radius",
            "they stand in comments that a plain reader skips; written and read without loss",
        ),
        Claim(
            "3.3",
            "n = 1661, m = 60, p = 141: 8.4 % of the pixels suffice",
            "benchmarks/paper/arena.py::reduce",
            f"{PAPER}::test_the_arena_is_reduced_as_in_the_paper",
            f"141 / 1661 is 8.5 %. Here n = {m.reductions[0].border_pixels}, m ="
            f" {m.reductions[0].vertices}, p = {m.reductions[0].generators}:"
            f" {100 * m.reductions[0].share:.1f} %",
            f"m = {m.reductions[1].vertices}, p = {m.reductions[1].generators}:"
            f" {100 * m.reductions[1].share:.1f} %",
        ),
    ]


def _costs(m: Measured) -> list[Claim]:
    from benchmarks.paper.timing import our_fits, paper_fits

    full, reduced = paper_fits()
    ours, _ = our_fits([r for r in m.rows if r.border_pixels >= 1_000], "diagram")
    last = m.rows[-1]
    gain = last.full_diagram_ms / last.reduced_diagram_ms
    return [
        Claim(
            "3.3, 5",
            "O(n), average, for the full and for the reduced pixels",
            "planner/delaunay/voronoi_diagram.py::voronoi_arrays",
            f"{PAPER}::test_the_papers_table_is_not_linear_and_its_38_percent_is_a_ratio_of_slopes",
            f"Table 1 itself grows as n^{full.exponent:.2f} (full) and n^{reduced.exponent:.2f}"
            " (reduced): nearly quadratic, so its straight lines do not pass through zero",
            f"n^{ours.exponent:.2f} from 1,661 to {last.border_pixels:,} border pixels",
        ),
        Claim(
            "3.3",
            "The reduced approach is better by an order of 38 %",
            "benchmarks/paper/timing.py::paper_fits",
            f"{PAPER}::test_the_papers_table_is_not_linear_and_its_38_percent_is_a_ratio_of_slopes",
            f"38 % is the ratio of slopes, each over its own pixels"
            f" ({reduced.slope:.1f} / {full.slope:.1f} ms ="
            f" {100 * reduced.slope / full.slope:.1f} %): the cost of a generator. For one"
            f" picture the same table says {18790 / 660:.0f} times",
            f"diagram alone {gain:.0f} times less at n = {last.border_pixels:,}",
        ),
        Claim(
            "3.3",
            "Corner detection must be counted too (the paper's own caveat)",
            "vision/paper/paper.py::paper_objects",
            f"{PAPER}::test_table_1_counts_what_the_paper_counts",
            f"With a diagram at {1e3 * last.full_diagram_ms / last.border_pixels:.2f} us a pixel"
            f" the corners cost more than they save: {last.full_chain_ms:.0f} ms full,"
            f" {last.reduced_chain_ms:.0f} ms reduced, at n = {last.border_pixels:,}",
            f"structure is worth it for what it says, not for time: exact clearances, arcs,"
            f" objects. {last.default_chain_ms:.0f} ms to the exact roadmap",
        ),
    ]


def _robot(m: Measured) -> list[Claim]:
    wide, usual = m.clearances[-1], m.clearances[1]
    paper, exact = m.completeness["paper"], m.completeness["exact"]
    return [
        Claim(
            "4",
            "delta < 2 r is the threshold for a robot of radius r",
            "planner/borders/generators.py::choose_spacing",
            f"{PAPER}::test_sampled_clearance_is_unsafe_and_exact_clearance_is_not",
            "It keeps the robot's centre from passing between two generators, no more: a place"
            " r from all generators may be sqrt(r^2 - delta^2 / 4) from the wall. Least true"
            f" clearance at delta = {usual.spacing:g} r: {usual.sampled:.2f} r; at"
            f" {wide.spacing:g} r: {wide.sampled:.2f} r",
            f"clearance is the distance to the borders: never below {wide.exact:.2f} r",
        ),
        Claim(
            "4",
            "In a closed workspace the AGVD is connected and reaches all of C_free",
            "planner/roadmap/roadmap.py::build_roadmap",
            f"{COMPLETE}::test_path_is_found_exactly_when_one_exists_in_random",
            f"Not so with whole objects as owners: {paper.joined - paper.planned} of"
            f" {paper.joined} pairs that a grid joins are not planned",
            f"{exact.joined - exact.planned} of {exact.joined} missed, {exact.invented} of"
            f" {exact.apart} invented",
        ),
        Claim(
            "4",
            "Omitted edges would lead to collisions; the rest is collision-free",
            "planner/roadmap/roadmap.py::Roadmap",
            f"{ROADMAP}::test_graph_keeps_the_radius_and_its_clearances_are_exact",
            "Valid edges can still be too narrow for the robot",
            "the graph holds only what keeps the radius, by exact distance",
        ),
        Claim(
            "4",
            "The roadmap as a graph; start and goal leave and join it; shortest path",
            "planner/route/route.py::plan_request",
            "tests/planner/route/test_route.py::test_start_attaches_inside_an_edge_without_a_detour",
            "How to join is not told",
            "by retraction, inside an edge; widest, shortest or between; why not, where not",
        ),
    ]


def _share_missed(m: Measured) -> str:
    paper = m.completeness["paper"]
    return f"{100 * (paper.joined - paper.planned) / max(paper.joined, 1):.0f} %"
