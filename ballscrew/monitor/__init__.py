"""The monitor beside the machine: session, monitor, left_out, status, json_lines, display."""
