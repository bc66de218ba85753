"""Patients: search, add, change, consents, and the history of their sessions."""
