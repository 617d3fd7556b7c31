"""The eye of a run with several cameras over one arena, and how it is made of a configuration."""
