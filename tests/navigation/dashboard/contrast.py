"""Contrast of two colours of the page."""

from navigation.draw.shapes import Colour


def contrast(one: Colour, other: Colour) -> float:
    """Contrast of two colours, from 1 to 21.

    Source: Web Content Accessibility Guidelines 2.2, definition of contrast ratio.
    """
    brighter, darker = sorted((_luminance(one), _luminance(other)), reverse=True)
    return (brighter + 0.05) / (darker + 0.05)


def _luminance(colour: Colour) -> float:
    linear = [
        c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4
        for c in (value / 255.0 for value in colour)
    ]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
