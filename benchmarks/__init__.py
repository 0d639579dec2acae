"""Long studies: how accurate, how fast. `make bench` runs them and writes RESULTS.md."""
