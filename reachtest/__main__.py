"""`python -m reachtest`."""

from reachtest.cli import main

main()
