"""A simulated clinic: bodies, sensors and scenes with exact truth."""
