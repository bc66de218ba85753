"""The store of patients, sessions, captures and their sealed files."""
