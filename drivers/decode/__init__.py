"""Frames into ticks: decode, dbc, sources, checks, scan, drive, condense, clock, scans, ticks."""
