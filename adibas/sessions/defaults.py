"""What the command line and the window offer before they load the store."""

BACKUP_ENDING = ".adibas-backup"
DAYS_BETWEEN_BACKUPS, N_BACKUPS_KEPT = 7, 4
RETENTION_YEARS, CHILD_UNTIL_AGE = 15, 25
"""No legal advice; see `docs/backup.md`."""
ADULT_AGE = 18
