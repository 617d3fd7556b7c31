"""Tests of pictures without grey: edges that separate the pixels."""
