"""Markers in colour images: learned, found, measured in 3-D."""
