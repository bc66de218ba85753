"""What is ordered at the clinic, looked up in a work list: a patient, or a session's export."""
