"""Review: look at a session's captures, correct their markers, and measure between them."""
