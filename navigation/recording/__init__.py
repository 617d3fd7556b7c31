"""What a run recorded: events into MCAP files, read back, replayed and compared."""
