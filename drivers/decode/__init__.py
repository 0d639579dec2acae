"""Frames into ticks: decode, dbc, sources, checks, scan, drive, condense, clock, ticks."""
