"""Joint angles over time and ranges of movement, from the fifteen joints."""
