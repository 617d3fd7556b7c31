"""The figures of the documents: each is drawn by the code as it runs, and stands in a document."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from benchmarks.figures.__main__ import FIGURES

DOCS = Path(__file__).parents[3] / "docs"


def test_every_figure_stands_in_a_document_and_was_drawn() -> None:
    text = (DOCS / "outlines.md").read_text() + (DOCS / "diagram.md").read_text()
    shown = re.findall(r"\]\(pictures/([\w-]+\.svg)\)", text)
    assert sorted(shown) == sorted(FIGURES)
    assert all((DOCS / "pictures" / name).is_file() for name in FIGURES)


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_drawn(name: str) -> None:
    root = ET.fromstring(FIGURES[name]())
    drawn = [child for child in root.iter() if child.tag.endswith(("path", "circle"))]
    assert len(drawn) > 10
    assert float(root.attrib["width"]) > 600.0
