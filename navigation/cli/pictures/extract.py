"""`clearway extract`: a picture's obstacles."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Literal

import click

from navigation.cli.cold_kernels import compile_what_is_missing
from navigation.cli.options import (
    INPUT,
    LEAST_AREA_OPTION,
    OUTPUT,
    Binarising,
    OutputType,
    binarise_options,
    format_option,
)
from navigation.cli.outputs import (
    CommandError,
    keep_apart,
    named,
    tell_times,
    warn_of_doubts,
    write_text,
)
from navigation.cli.progress import long_work


@click.command(short_help="The geometric structure of a picture.")
@click.argument("image", type=INPUT)
@format_option("The paper's records, or one JSON object.")
@click.option("-o", "--output", type=OUTPUT, help="Write the answer to this file.")
@click.option("--paper", is_flag=True, help="Follow the paper's method to the letter.")
@binarise_options
@LEAST_AREA_OPTION
@click.option(
    "--render",
    type=OutputType(".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp", ".svg"),
    help="Draw the records over the picture: FILE.png or FILE.svg.",
)
@click.option("--timings", is_flag=True, help="Write the stages' times into the output file, too.")
def command(
    image: Path,
    form: Literal["text", "json"],
    output: Path | None,
    paper: bool,
    binarising: Binarising,
    least_area: float | None,
    render: Path | None,
    timings: bool,
) -> None:
    """Find the obstacles in IMAGE and print their records P, S, C, A and L.

    Coordinates are pixels, x right, y down, pixel centres at integers, in the picture as viewers
    show it: turned by its EXIF orientation.
    """
    keep_apart((("--output", output), ("--render", render)), (image,))

    import vision
    from navigation.cli.pictures.sources import decode_picture, read_source
    from planner.formats.scene_io import write_scene_text
    from planner.formats.scene_json import scene_to_json

    begin_s = time.perf_counter()
    picture, remarks = decode_picture(read_source(image), named(image))
    load_ms = 1e3 * (time.perf_counter() - begin_s)
    compile_what_is_missing("eye")
    try:
        with long_work("looking for obstacles"):
            scene = vision.extract(
                picture,
                mode="paper" if paper else "exact",
                **binarising._asdict(),
            )
    except ValueError as error:
        raise CommandError(f"{named(image)}: {error}") from error
    if least_area is not None:
        scene = scene.without_specks(least_area)
        click.echo(f"clearway: {named(image)}: {scene.remarks[-1]}", err=True)
    total_ms = 1e3 * (time.perf_counter() - begin_s)
    timings_ms = {"load": load_ms, **scene.timings_ms, "total": total_ms}
    scene = replace(scene, timings_ms=timings_ms, remarks=(*remarks, *scene.remarks))
    warn_of_doubts(scene, image)
    # the same answer each time, unless times are asked for
    timed = timings or (form == "json" and output is None)
    written = scene if timed else replace(scene, timings_ms={})
    if form == "json":
        write_text(output, json.dumps(scene_to_json(written), indent=1) + "\n")
    else:
        write_text(output, write_scene_text(written))
    if form == "text":
        tell_times(timings_ms)
    if render is not None:
        from navigation.draw.overlay import overlay_drawing
        from navigation.draw.picture import save_drawing

        with long_work("drawing"):
            save_drawing(render, overlay_drawing(picture, scene, named(image).name))
