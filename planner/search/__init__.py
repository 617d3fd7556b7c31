"""Searches along chains, around corners, and through several stations."""
