"""Nav-mesh files: a reader for each format, and the table that tells which of them a file is."""
