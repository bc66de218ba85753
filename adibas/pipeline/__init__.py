"""The only place that puts stages in order."""
