"""Stage findings."""
