"""The monitor beside the machine: session, monitor, status, json_lines, display."""
