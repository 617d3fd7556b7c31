"""The section `recording` of a configuration."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final, Literal

from pydantic import Field, StrictBool

from navigation.config.values import Positive, Rate, Section

ZONES_FILE: Final = "zones"
"""Ending of the file beside the journal in which changed zones are."""


class RecordingSection(Section):
    """Files that a run leaves behind."""

    runs_dir: Path = Field(
        default=Path("runs"),
        description="each run makes a folder in this one (from the current folder)",
    )
    journal: Path | None = Field(
        default=None,
        description="file that keeps mission and progress, and beside it zones that people "
        "change, so that a restart resumes where it was (from the current folder); empty: a "
        "restart begins again",
    )
    record: StrictBool = Field(
        default=False,
        description="record pictures, scenes, zones, plans, poses and log into MCAP files, which "
        "`clearway replay` and Foxglove read",
    )
    folder: Path = Field(
        default=Path("recordings"),
        description="where the MCAP files go (from the current folder); `run --record` overrides",
    )
    limit_mb: Annotated[Positive, Field(ge=1)] = Field(
        default=2000.0,
        description="the oldest MCAP files there go when all are larger than this; one named by "
        "`run --record FILE.mcap` ends at it",
    )
    file_mb: Annotated[Positive, Field(ge=0.1)] = Field(
        default=200.0,
        description="a new MCAP file is begun when one has become larger than this, except where "
        "it was named",
    )
    picture_rate_hz: Rate = Field(
        default=10.0, description="most pictures a second that are recorded"
    )
    picture_format: Literal["jpeg", "png"] = Field(
        default="jpeg", description="small, or without loss (about ten times the processor time)"
    )
    jpeg_quality: Annotated[int, Field(strict=True, ge=1, le=100)] = Field(
        default=92, description="of recorded pictures"
    )
