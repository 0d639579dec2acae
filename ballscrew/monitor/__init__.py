"""The monitor beside the machine: session, monitor, resume, left_out, status, json_lines, display."""
