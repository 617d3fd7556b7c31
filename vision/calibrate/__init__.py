"""Making a calibration: boards, lenses, surveys of an arena, sheets to print."""
