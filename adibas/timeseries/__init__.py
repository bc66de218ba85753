"""Alignment of series in time, and filters: pure maths on arrays."""
