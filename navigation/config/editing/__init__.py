"""Changing a configuration: values put into its text, and a form for those who edit no text."""
