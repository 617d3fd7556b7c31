"""The figures of docs/outlines.md and docs/diagram.md, from the running code."""
