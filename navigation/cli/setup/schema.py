"""`clearway schema`: the keys of a configuration."""

from __future__ import annotations

import json
from pathlib import Path

import click

from navigation.cli.outputs import write_text


@click.command(short_help="The configuration's JSON Schema.")
@click.option(
    "--format",
    "form",
    type=click.Choice(["json", "markdown"]),
    default="json",
    show_default=True,
    help="JSON Schema for editors, or the reference for people.",
)
@click.option(
    "-o", "--output", type=click.Path(path_type=Path, dir_okay=False), help="File to write."
)
def command(form: str, output: Path | None) -> None:
    """Print the JSON Schema of a configuration, or its reference as Markdown."""
    from navigation.config.reference import json_schema, reference_markdown

    text = (
        reference_markdown() if form == "markdown" else json.dumps(json_schema(), indent=2) + "\n"
    )
    write_text(output, text)
