"""Tests of planning several robots."""
