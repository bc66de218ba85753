"""Video beside a timeline: what an observer codes, what the program found, and what both count."""
