"""`python -m ballscrew`."""

from ballscrew.cli import main

main()
