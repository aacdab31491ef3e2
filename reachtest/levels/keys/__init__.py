"""`level.yaml`, key by key: what the file may say, how it is read, and what is said of mistakes in it."""
