"""What no outgoing text may show: which words are secret, and where they are in a file."""
