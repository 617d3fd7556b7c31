"""What the page is told: states, geometry, pictures, the log and the charts."""
