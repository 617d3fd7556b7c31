"""The dashboard's section."""

from __future__ import annotations

import ipaddress
from typing import Annotated

from pydantic import Field, StrictBool

from navigation.config.values import Positive, Section, Text

Token = Annotated[
    str, Field(strict=True, min_length=16, max_length=256, pattern=r"^[A-Za-z0-9_~.-]+$")
]
"""Characters that need no quoting in an address."""


class DashboardSection(Section):
    """The page that shows the arena and takes orders."""

    enabled: StrictBool = Field(default=True, description="whether `clearway run` serves it")
    host: Text = Field(
        default="127.0.0.1",
        description="address to listen at; any but this machine's own needs a token",
    )
    port: Annotated[int, Field(strict=True, ge=0, le=65535)] = Field(
        default=8421, description="port to listen at; 0: any that is free"
    )
    token: Token | None = Field(
        default=None,
        description="at least 16 letters, digits, _ ~ . or -; anyone who knows it may drive "
        "(better in the environment: CLEARWAY_DASHBOARD__TOKEN); empty: made and printed by the "
        "program, and looking needs none",
    )
    viewer_token: Token | None = Field(
        default=None, description="anyone who knows only this one may watch and stop, not drive"
    )
    supervisor_token: Token | None = Field(
        default=None,
        description="anyone who knows it may drive, and take control from anyone, at once",
    )
    names: tuple[Text, ...] = Field(
        default=(), max_length=100, description="further host names that browsers reach it by"
    )
    hold_s: Positive = Field(
        default=300.0, description="the arena is free again when its operator did nothing for this"
    )
    picture_width_px: Annotated[int, Field(strict=True, ge=160, le=4096)] = Field(
        default=960, description="largest width of the pictures that viewers get"
    )
    picture_rate_hz: Annotated[Positive, Field(le=120)] = Field(
        default=10.0, description="most pictures a second that one viewer gets"
    )
    jpeg_quality: Annotated[int, Field(strict=True, ge=10, le=100)] = Field(
        default=60, description="of the pictures"
    )

    @property
    def is_local(self) -> bool:
        """True if only this machine can reach it."""
        if self.host == "localhost":
            return True
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return False
