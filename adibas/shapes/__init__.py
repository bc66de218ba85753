"""Sets of points as shapes: what they have in common, how they vary, which point is which."""
