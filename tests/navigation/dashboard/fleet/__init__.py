"""The page of several robots: what it is told, and its colours."""
