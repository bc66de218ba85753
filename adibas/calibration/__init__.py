"""Board images and depth to a calibration, and its files."""
