"""The commands, one file for each group; cli.py lists them. Heavy packages are imported inside the functions."""
