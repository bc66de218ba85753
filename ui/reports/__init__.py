"""Reports of one session or of several: a preview, and files to hand out."""
