"""Every number of a configuration has limits, and no text of one fills the machine's memory."""

from __future__ import annotations

import resource
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from navigation.config import ConfigError, load_config, parse_config
from navigation.config.load import MOST_BYTES
from navigation.config.marks import MOST_CHARACTERS, MOST_DEPTH, MOST_VALUES
from navigation.config.reference import json_schema
from navigation.config.values import LONGEST_DWELL_S, MOST_STATIONS
from navigation.orders.arguments import read_stations
from navigation.orders.errors import ControlError
from tests.navigation.config.texts import GOOD

MEMORY_BYTES = 1_500_000_000


def refusal_of(text: str) -> str:
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "a.yaml")
    return str(caught.value)


def numbers_of(schema: Any, root: Any, name: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Every number in a JSON Schema with its name."""
    if "$ref" in schema:
        schema = root["$defs"][schema["$ref"].rpartition("/")[2]]
    for inner in schema.get("anyOf", []) + schema.get("prefixItems", []):
        yield from numbers_of(inner, root, name)
    if isinstance(schema.get("items"), dict):
        yield from numbers_of(schema["items"], root, f"{name}[]")
    for key, inner in schema.get("properties", {}).items():
        yield from numbers_of(inner, root, f"{name}.{key}")
    if schema.get("type") in ("number", "integer"):
        yield name, schema


def test_every_number_has_a_smallest_and_a_largest_value() -> None:
    schema = json_schema()
    numbers = list(numbers_of(schema, schema, ""))
    assert len(numbers) > 80
    checked_by_hand = {".camera.source", ".cameras[].source", ".planning.prefer"}
    for name, one in numbers:
        if name in checked_by_hand:
            continue
        assert one.keys() & {"minimum", "exclusiveMinimum"}, name
        assert one.keys() & {"maximum", "exclusiveMaximum"}, name


@pytest.mark.parametrize(
    ("old", "new", "where", "limit"),
    [
        ("y_m: 0.2}", "y_m: 0.2, heading_deg: 1e300}", "9:..", "must be <= 3600"),
        ("radius_m: 0.09", "radius_m: 1e-9", "8:13", "must be >= 0.001"),
        ("[0, 0, 2.4, 1.8]", "[0, 0, 1e300, 1.8]", "2:20", "must be <= 1000"),
        ("marker_id: 7", "marker_id: 99999999999", "6:14", "must be <= 4.29497e+09"),
        ("marker_id: 7", f"marker_id: {'9' * 5000}", "6:14", "is no int"),
        ("marker_id: 7", f"marker_id: 0x{'f' * 5000}", "6:14", "must be"),
        ("radius_m: 0.09", f"radius_m: 0x{'f' * 5000}", "8:13", "must be"),
        ("radius_m: 0.09", "radius_m: 1e400", "8:13", "must be a finite number"),
    ],
)
def test_numbers_beyond_their_limits_are_told_at_their_place(
    old: str, new: str, where: str, limit: str
) -> None:
    assert old in GOOD
    text = refusal_of(GOOD.replace(old, new, 1))
    assert limit in text
    assert where.endswith("..") or f"a.yaml:{where}: " in text


@pytest.mark.parametrize(("dwell", "is_good"), [(LONGEST_DWELL_S, True), (1e300, False)])
def test_a_stay_has_a_limit_in_the_configuration_and_in_orders(dwell: float, is_good: bool) -> None:
    mission = f"mission:\n  stations:\n    - {{x_m: 1.0, y_m: 0.3, dwell_s: {dwell}}}\n"
    order = [{"x_m": 1.0, "y_m": 0.3, "dwell_s": dwell}]
    if is_good:
        assert parse_config(GOOD + mission).mission.stations[0].dwell_s == dwell
        assert read_stations(order)[0].dwell_s == dwell
        return
    assert "a.yaml:14:37: mission.stations[0].dwell_s: must be <= 3600" in refusal_of(
        GOOD + mission
    )
    with pytest.raises(ControlError, match=r"dwell_s = 1e\+300: must be <= 3600"):
        read_stations(order)


def test_stations_are_bounded_in_number() -> None:
    lines = "    - {x_m: 1.0, y_m: 0.3}\n" * (MOST_STATIONS + 1)
    assert f"at most {MOST_STATIONS} " in refusal_of(GOOD + "mission:\n  stations:\n" + lines)


def test_a_spacing_far_too_fine_for_the_arena_is_told() -> None:
    wide = GOOD.replace("[0, 0, 2.4, 1.8]", "[0, 0, 1000, 1000]")
    text = refusal_of(wide + "planning: {spacing_m: 0.001}\n")
    assert "planning.spacing_m: must be >= 0.004 in an arena of this size, not 0.001" in text


BOMB = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1]\n" + "".join(
    f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]\n" for n in range(1, 10)
)


@pytest.mark.parametrize(
    ("text", "place", "limit"),
    [
        (BOMB, "5:", f"has more than {MOST_VALUES} values, with its aliases written out"),
        ("a: " + "[" * 100_000, "1:", f"is nested too deeply: more than {MOST_DEPTH} levels"),
        ("".join(f"{' ' * n}a:\n" for n in range(900)), "", f"more than {MOST_DEPTH} levels"),
        ("a: " + "x" * MOST_CHARACTERS, "1:1", f"is longer than {MOST_CHARACTERS} characters"),
        ("a: [" + "1," * (MOST_VALUES + 1) + "1]", "1:", f"has more than {MOST_VALUES} values"),
        ("a: &a [*a]\n", "1:", "an alias inside itself"),
        ("a: 1\na: 2\n", "2:1", "the key 'a' is here a second time, first in line 1"),
    ],
    ids=["aliases", "brackets", "indents", "length", "values", "itself", "twice"],
)
def test_a_text_that_is_no_configuration_is_told_at_its_place(
    text: str, place: str, limit: str
) -> None:
    sentence = refusal_of(text)
    assert limit in sentence
    assert f"a.yaml:{place}" in sentence
    assert len(sentence) < 2000


def test_nested_aliases_take_no_memory(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(BOMB)
    program = [sys.executable, "-c", "from navigation.cli.main import main; main()"]

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))

    done = subprocess.run(
        [*program, "check", tmp_path / "a.yaml"],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=limit,
    )
    assert done.returncode == 78, done.stderr
    assert "with its aliases written out" in done.stderr


def test_a_file_without_an_end_is_not_read_for_ever(tmp_path: Path) -> None:
    for file in (Path("/dev/zero"), tmp_path / "large.yaml"):
        if not file.exists():
            file.write_bytes(b"a" * (MOST_BYTES + 1))
        with pytest.raises(ConfigError, match=f"is larger than {MOST_BYTES} bytes"):
            load_config(file, {})
