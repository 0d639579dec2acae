"""The monitor beside the machine."""
