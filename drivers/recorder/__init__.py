"""Every frame of a bus, on the disk."""
