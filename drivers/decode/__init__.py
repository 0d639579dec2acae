"""Frames into ticks."""
