"""Numbers on paper: Excel, CSV and JSON."""
