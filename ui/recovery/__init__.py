"""The recovery key in the window: shown once, printed, saved as a PDF, kept."""
