"""Is the level plausible? What would make every result wrong, and what looks odd."""
