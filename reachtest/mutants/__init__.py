"""Plants bugs in a level, one at a time, and decides by geometry alone whether each really is one."""
