"""What a character must be able to do and what it must not, as small pieces of level with a script to walk."""
