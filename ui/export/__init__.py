"""A session for other systems: FHIR, DICOM files, or sent to a server of the clinic."""
