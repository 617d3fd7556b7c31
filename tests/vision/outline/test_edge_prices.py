"""Prices of edges: noise alone must hardly ever buy one, and a true corner always."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.drawn.render import cut_disc, draw, polygon
from vision import extract
from vision.outline.fit.edge_prices import LEAST_LINE, edge_prices, saving_of_noise


def saved_by_one_number(dead_zone: float, sigma: float, spread: float) -> float:
    """What a free offset saves on noise, found by trying every offset: the mean of 400."""
    rng = np.random.default_rng(4)
    offsets = np.linspace(-0.5, 0.5, 201) * spread
    saved = []
    for _ in range(400):
        noise = rng.normal(0.0, spread, 120)
        beyond = np.maximum(np.abs(noise[:, None] - offsets) - dead_zone, 0.0)
        costs = np.square(beyond / sigma).sum(axis=0)
        saved.append(costs[100] - costs.min())
    return float(np.mean(saved))


@pytest.mark.parametrize(
    ("dead_zone", "sigma", "spread"), [(0.0, 0.2, 0.2), (0.06, 0.23, 0.2), (0.12, 0.25, 0.2)]
)
def test_what_noise_saves_is_what_a_search_finds(
    dead_zone: float, sigma: float, spread: float
) -> None:
    expected = saving_of_noise(dead_zone, sigma, spread)
    assert saved_by_one_number(dead_zone, sigma, spread) == pytest.approx(expected, rel=0.15)


def test_without_noise_a_price_is_the_least_and_noise_never_lowers_it() -> None:
    assert saving_of_noise(0.1, 0.05, 0.0) == 0.0
    assert edge_prices(0.12, 0.05, 0.0)[0] == LEAST_LINE
    lines = [edge_prices(0.06, math.hypot(0.05, s), s)[0] for s in np.linspace(0.0, 0.5, 26)]
    assert np.all(np.diff(lines) >= 0.0)
    assert lines[-1] > LEAST_LINE


def corner_counts(vertices: np.ndarray, blur: float, noise: float, seed: int) -> int:
    rng = np.random.default_rng([seed, 5])
    scene = extract(draw([polygon(vertices)], (120, 120), blur=blur, noise=noise, rng=rng))
    (only,) = scene.objects
    return len(getattr(only.records[0], "edges", ()))


def test_noise_breaks_hardly_any_straight_side() -> None:
    square = np.array([(-30, -30), (30, -30), (30, 30), (-30, 30)], dtype=float)
    extra = 0
    for seed in range(60):
        a = 0.1 * seed
        turn = np.array([[math.cos(a), math.sin(a)], [-math.sin(a), math.cos(a)]])
        extra += corner_counts(square @ turn + 60.0, 1.5, 20.0, seed) - 4
    # of 240 sides; at the price of a calm picture thirteen break
    assert extra <= 6


def test_corners_of_150_degrees_between_sides_of_16_px_survive_the_noise() -> None:
    radius = 8.0 / math.sin(math.pi / 12.0)
    for seed in range(25):
        t = np.arange(12) * math.tau / 12.0 + 0.13 * seed
        vertices = 60.0 + radius * np.stack([np.cos(t), np.sin(t)], axis=1)
        assert corner_counts(vertices, 0.7, 20.0, seed) == 12, f"seed {seed}"


def test_a_long_arc_stays_one_under_noise() -> None:
    whole = 0
    for seed in range(40):
        rng = np.random.default_rng([seed, 6])
        center = 70.0 + rng.uniform(-0.5, 0.5, 2)
        disc = cut_disc(center, 50.0, float(rng.uniform(0.0, math.tau)), 0.6)
        scene = extract(draw([disc], (140, 140), noise=20.0, rng=rng))
        whole += len(scene.objects[0].records[0].edges) == 2
    # fitted through a sample of its points, one in five broke
    assert whole >= 39
