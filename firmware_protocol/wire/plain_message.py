"""A message whose fields are the payload's integers, in their order."""

from __future__ import annotations

from struct import Struct
from typing import ClassVar, Self

from firmware_protocol.wire.values import unpack_exactly
from firmware_protocol.wire.vocabulary import MessageType


class PlainMessage:
    """Base of the dataclasses with slots that are such messages."""

    __slots__: tuple[str, ...] = ()
    TYPE: ClassVar[MessageType]
    LAYOUT: ClassVar[Struct]

    def pack(self) -> bytes:
        """The payload."""
        return self.LAYOUT.pack(*(getattr(self, name) for name in self.__slots__))

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; RemoteError if its size differs."""
        return cls(*unpack_exactly(cls.TYPE.name, cls.LAYOUT, payload))
