"""Two sessions of a patient beside one another, measures over time, and how well they repeat."""
