"""Frames into ticks: decode, dbc, sources, buses, addresses, checks, scan, drive, condense, clock, scans, ticks."""
