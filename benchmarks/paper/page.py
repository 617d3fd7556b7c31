"""docs/paper/README.md: the figures and tables with their numbers and commands."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.paper.claims import claims
from benchmarks.paper.inputs import PAPER_BORDER_PIXELS, PAPER_GENERATORS, PAPER_VERTICES
from benchmarks.paper.measured import NOISES, OCTAGON_RADII, Measured
from benchmarks.paper.timing import PAPER_TABLE, Row, our_fits, paper_fits
from benchmarks.paper.weaknesses import MODES

TOP = Path(__file__).parents[2]
RESULTS = TOP / "benchmarks" / "results"
NAMES = {"paper": "paper", "exact": "default"}


def page(m: Measured) -> str:
    """The whole page."""
    parts = (_head, _figures, _reduction, _table_1, _claims, _corners, _circles, _beyond, _others)
    return "\n".join(line for part in parts for line in part(m)) + "\n"


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> Iterator[str]:
    """A Markdown table and a blank line."""
    yield "| " + " | ".join(head) + " |"
    yield "|" + "---|" * len(head)
    for row in rows:
        yield "| " + " | ".join(str(cell) for cell in row) + " |"
    yield ""


def _head(m: Measured) -> Iterator[str]:
    yield from (
        "# The paper, reproduced",
        "",
        "Roque and Doering, *Constructing Approximate Voronoi Diagrams from Digital Images of",
        "Generalized Polygons and Circular Objects*: its figures, its tables and its claims, made",
        "and measured by this code. `make paper` makes this page and its figures again, from",
        'seeds; all numbers but the times come out the same. "The paper\'s way" is `--paper`,',
        '`mode="paper"`: its recipe to the letter. Where each step lives, and why the default',
        "does otherwise, is in [The method](../method.md). Lengths are in pixels unless said",
        "otherwise.",
        "",
    )


def _figures(m: Measured) -> Iterator[str]:
    told = (
        ("Figure 1", "The ordinary diagram of 14 generators."),
        (
            "Figure 2",
            "The insertion of the 15th. The walk is made from the 14 points' diagram as section "
            "2.3 tells it; the kernel's diagram of all 15 has the same region.",
        ),
        (
            "Figure 3",
            "The diagram of generators along generalized polygons, with all its edges. Those "
            "inside one object, and between neighbours on one border, are invalid.",
        ),
        (
            "Figure 4",
            "Without them. The default mode's edges are the bisectors themselves, and those that "
            "lead into corners stay, as far as the robot fits.",
        ),
        (
            "Figure 5",
            "A picture like the paper's arena, the minimum structure, and the diagrams.",
        ),
        (
            "Figure 6",
            "Linear fits. Above: time of the diagram over its generators, on plain axes. Below: "
            "over the border pixels of the picture.",
        ),
        (
            "Figure 7",
            "Beyond the paper: how unequal the distances to both sides are along the diagram "
            "(95th percentile), against delta.",
        ),
    )
    for name, text in told:
        number = name.split()[1]
        yield from (f"## {name}", "", text, "", f"![{name}](figure-{number}.svg)", "")


def _reduction(m: Measured) -> Iterator[str]:
    paper, ours = m.reductions
    simple, generalized, circles = m.kinds["exact"]
    yield from (
        "## The reduction",
        "",
        f"{simple} simple polygons, {generalized} generalized polygons, {circles} circle, found"
        f" in figure 5's picture. delta = {paper.spacing:g} px is chosen so that p is the paper's;"
        f" the walls of the bounds take {paper.walls} generators more, which the paper does not"
        " count.",
        "",
    )
    n, v, p = PAPER_BORDER_PIXELS, PAPER_VERTICES, PAPER_GENERATORS
    yield from table(
        ("", "border pixels n", "vertices m", "generators p", "p / n"),
        [
            ("the paper", n, v, p, f"{100 * p / n:.1f} % (it says 8.4 %)"),
            *(
                (name, r.border_pixels, r.vertices, r.generators, f"{100 * r.share:.1f} %")
                for name, r in (("here, the paper's way", paper), ("here, by default", ours))
            ),
        ],
    )


def _table_1(m: Measured) -> Iterator[str]:
    yield from (
        "## Table 1",
        "",
        "Milliseconds of one thread's processor time, medians (41 runs to 1,661 pixels, then 7,"
        " then 3) on a shared machine: compare within a row. *Seeing* is binarising and"
        " following contours, part of every chain. *Corners* are corners, circles and records of"
        " the paper's mode, in brackets their compiled part; the rest is Python that makes"
        " records. The default chain ends with the exact roadmap, the other two with valid edges.",
        "",
    )
    head = (
        "n", "p", "p / n", "full: diagram", "reduced: diagram", "gain", "seeing", "corners",
        "full: chain", "reduced: chain", "default: chain",
    )  # fmt: skip
    yield from table(head, [_times(r) for r in m.rows])
    yield from ("The paper's own:", "")
    yield from table(
        ("full pixels", "ms", "reduced pixels", "ms", "gain"),
        [(a, b, c, d, f"{b / d:.0f} x") for a, b, c, d in PAPER_TABLE],
    )
    small = [r for r in m.rows if r.border_pixels < 1_000]
    large = [r for r in m.rows if r.border_pixels >= 1_000]
    fits = [
        ("the paper's table", *paper_fits()),
        ("here, diagram, its five sizes", *our_fits(small, "diagram")),
        (f"here, diagram, 1,661 to {m.rows[-1].border_pixels:,}", *our_fits(large, "diagram")),
        ("here, whole chain, the same", *our_fits(large, "chain")),
    ]
    yield from (
        "Linear fits, each over its own pixels as in the paper: microseconds for one more full"
        " pixel, for one more reduced pixel, their ratio (the paper's 38 %), and the exponents"
        " that the times really grow with:",
        "",
    )
    yield from table(
        ("", "full us", "reduced us", "ratio", "full exponent", "reduced exponent"),
        [
            (
                name,
                f"{1e3 * full.slope:,.2f}",
                f"{1e3 * reduced.slope:,.2f}",
                f"{100 * reduced.slope / full.slope:.0f} %",
                f"{full.exponent:.2f}",
                f"{reduced.exponent:.2f}",
            )
            for name, full, reduced in fits
        ],
    )
    yield from (
        "What that says: the paper's 38 % is the ratio of these slopes, that is of the costs of"
        " one generator. Its program took time near n^1.8, so that fewer generators were cheaper"
        " each. Where the diagram takes linear time, a generator costs the same either way, and"
        " what is saved is p / n itself. For the whole chain the paper's caveat decides: a"
        " diagram this quick costs less than finding the structure, in full pixels too. The"
        " structure pays by what it knows: arcs, objects, and exact distances to them.",
        "",
    )


def _times(r: Row) -> tuple[str, ...]:
    return (
        f"{r.border_pixels:,}",
        f"{r.generators:,}",
        f"{100 * r.generators / r.border_pixels:.1f} %",
        _ms(r.full_diagram_ms),
        _ms(r.reduced_diagram_ms),
        f"{r.full_diagram_ms / r.reduced_diagram_ms:.1f} x",
        _ms(r.seeing_ms),
        f"{_ms(r.corners_ms)} ({_ms(r.eigenvalues_ms)})",
        _ms(r.full_chain_ms),
        _ms(r.reduced_chain_ms),
        _ms(r.default_chain_ms),
    )


def _ms(value: float) -> str:
    return f"{value:,.0f}" if value >= 100.0 else f"{value:.2g}" if value < 1.0 else f"{value:.3g}"


def _claims(m: Measured) -> Iterator[str]:
    yield from ("## Every formula and claim", "")
    yield from table(
        ("section", "formula or claim", "code", "test", "found", "by default instead"),
        [(c.section, c.claim, _link(c.code), _link(c.test), c.found, c.instead) for c in claims(m)],
    )


def _link(place: str) -> str:
    path, name = place.split("::")
    words = name.removeprefix("test_").replace("_", " ") if "test_" in name else f"`{name}`"
    return f"[{words}](../../{path})"


def _corners(m: Measured) -> Iterator[str]:
    yield from (
        "## Corners",
        "",
        "48 turned polygons, sides from 26 px, angles from 60 to 129 and of 270 degrees; blur 0.7"
        " px, contrast 175.",
        "",
    )
    rows = []
    for noise in NOISES:
        for mode in MODES:
            c = m.corners[noise, mode]
            rows.append((f"{noise:g}", NAMES[mode], c.true, c.missed, c.false, f"{c.rms_px:.3f}"))
    yield from table(("noise", "way", "true", "missed", "false", "rms px"), rows)
    yield from (
        f"lambda_S of a perfect digital line reaches {m.line_floor:.4f}, the threshold is 0.1; of"
        " perfect corners: "
        + ", ".join(f"{a:g} degrees {v:.2f}" for a, v in m.corner_values.items())
        + ".",
        "",
    )


def _circles(m: Measured) -> Iterator[str]:
    yield from ("## Circles", "")
    rows = [
        (f"disc, {r:g}", f"{n:g}", NAMES[mode], f"{t.circles} of {t.shown}", _px(t.radius_error_px))
        for (r, n, mode), t in m.circles.items()
    ]
    rows += [
        (f"octagon, {r:g}", "0", NAMES[mode], f"{t.circles} of {t.shown}", _px(t.radius_error_px))
        for r in OCTAGON_RADII
        for mode in MODES
        for t in (m.octagons[r, mode],)
    ]
    yield from table(("shape, radius", "noise", "way", "taken for circles", "radius off by"), rows)
    yield from ("How far the true edge of a stadium sticks out of its record:", "")
    yield from table(
        ("radius of its arcs", "the paper's polygonal lines", "default"),
        [
            (f"{r:g}", *(f"{m.protrusions[r, mode]:.2f}" for mode in MODES))
            for r in sorted({r for r, _ in m.protrusions})
        ],
    )


def _px(value: float) -> str:
    return "-" if value != value else f"{value:.2f}"


def _beyond(m: Measured) -> Iterator[str]:
    yield from (
        "## Beyond: what a robot can rely on",
        "",
        "Random scenes of the planner's tests (polygons, circles, bars, points, stadiums, touching"
        " and crossing), robot radius 4; `python -m benchmarks.paper` measures these tables.",
        "",
        "The difference between the distances to both sides, along all edges that the robot can"
        " use (figure 7):",
        "",
    )
    yield from table(
        ("delta", "way", "median", "95 %", "worst", "beyond 1e-6", "places"),
        [
            (
                f"{e.spacing:g}",
                NAMES[e.mode],
                f"{e.median:.2g}",
                f"{e.high:.2g}",
                f"{e.worst:.2g}",
                f"{100 * e.off:.2g} %",
                f"{e.places:,}",
            )
            for e in m.errors
        ],
    )
    yield from (
        "The default's few places beyond are all on links that it keeps as sampled, most of them"
        " where a side gives way to its neighbour at a smooth joint; their clearance is measured"
        " against the borders all the same.",
        "",
        "The least true clearance, in robot radii, of a place where the robot is told that it"
        " fits. *Straight wall* is sqrt(1 - (delta / 2 r)^2), what the method can promise there;"
        " round and pointed obstacles are worse:",
        "",
    )
    yield from table(
        ("delta / r", "clearance to generators", "straight wall", "default: to the borders"),
        [
            (f"{c.spacing:g}", f"{c.sampled:.3f}", f"{c.allowed:.3f}", f"{c.exact:.3f}")
            for c in m.clearances
        ],
    )
    yield from (
        "Completeness. Pairs of places that a fine grid joins with a pixel to spare must be"
        " planned; pairs that it does not join with a pixel less must not. The judge's distances"
        " share no code with the planner. More of this:"
        " `python -m pytest tests/planner/route/test_route_completeness.py`.",
        "",
    )
    yield from table(
        ("way", "scenes", "joined", "planned", "apart", "planned all the same", "least clearance"),
        [
            (
                NAMES[c.mode], c.scenes, c.joined, c.planned, c.apart, c.invented,
                f"{c.least_clearance:.3f} r",
            )
            for c in m.completeness.values()
        ],
    )  # fmt: skip


def _others(m: Measured) -> Iterator[str]:
    yield from ("## Beyond: speed and faults", "")
    for name, title in (
        ("chain", "The whole chain beside its peers"),
        ("voronoi", "The diagram of points beside its peers"),
        ("vision", "Global Vision"),
        ("markers", "Marker poses"),
    ):
        file = RESULTS / f"{name}.md"
        if file.exists():
            yield f"- {title}: [{name}.md](../../benchmarks/results/{name}.md),"
            yield f"  by `python -m benchmarks.{name}`."
    yield ""
    for name in ("chain", "voronoi"):
        yield from _first_table(RESULTS / f"{name}.md")
    yield from faults_summary(RESULTS / "faults.md")


def _first_table(file: Path) -> Iterator[str]:
    """The first table of a result, with the heading and the line above it."""
    if not file.exists():
        return
    lines = file.read_text(encoding="utf-8").splitlines()
    rows = [i for i, line in enumerate(lines) if line.startswith("|")]
    if not rows:
        return
    last = first = rows[0]
    while last + 1 in rows:
        last += 1
    above = [line for line in lines[:first] if line.strip() and not line.startswith("# ")]
    title = lines[0].lstrip("# ").strip()
    yield from (f"### {title} (from {file.name})", "")
    if above:
        yield from (above[-1].lstrip("# "), "")
    yield from lines[first : last + 1]
    yield ""


def faults_summary(file: Path) -> Iterator[str]:
    """What `benchmarks/results/faults.md` comes to; columns are found by their names."""
    if not file.exists():
        return
    lines = file.read_text(encoding="utf-8").splitlines()
    cells = [[c.strip() for c in line.strip("|").split("|")] for line in lines if "|" in line]
    head, rows = cells[0], cells[2:]
    fault, runs, passed, what = (
        head.index(n) for n in ("fault", "runs", "passed", "what happened")
    )
    kinds: Counter[str] = Counter()
    for row in rows:
        for part in row[what].split("; "):
            count, _, name = part.partition(" x ")
            if count.isdigit():
                kinds[name] += int(count)
    yield from (
        "### Faults of the serial link (from faults.md)",
        "",
        f"{len({row[fault] for row in rows})} kinds of fault,"
        f" {sum(int(row[runs]) for row in rows)} runs,"
        f" {sum(int(row[passed]) for row in rows)} passed: the waypoints executed are those sent,"
        " or the robot stopped and the host said why. By `python -m benchmarks.faults`; the whole"
        " matrix is in [faults.md](../../benchmarks/results/faults.md).",
        "",
    )
    yield from table(("what happened", "runs"), kinds.most_common())
