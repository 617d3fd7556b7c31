"""The cameras and robots that a run opens: what it asks of them, and their drivers."""
