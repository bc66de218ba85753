"""What other systems of a clinic understand: FHIR for records, DICOM for picture archives."""
