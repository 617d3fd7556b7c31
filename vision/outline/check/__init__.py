"""What an outline is checked against: area lost, residuals, stray edges."""
