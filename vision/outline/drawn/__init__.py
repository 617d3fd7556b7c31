"""Drawn pictures, whose borders are exact: edges that separate the pixels."""
