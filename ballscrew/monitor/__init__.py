"""The monitor beside the machine: session, monitor, resume, left_out, explainer, drives, status, glance,
json_lines, display, beside."""
