"""Accuracy tables and speed against peers; `adibas benchmark` finds them here."""
