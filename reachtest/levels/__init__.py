"""Stage levels."""
