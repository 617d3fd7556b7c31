"""What every kernel shares: how it is compiled, and where its compiled code is kept."""
