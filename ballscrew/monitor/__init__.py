"""The monitor beside the machine: session, monitor, resume, left_out, explainer, status, json_lines, display."""
