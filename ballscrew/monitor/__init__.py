"""The monitor beside the machine: session, monitor, resume, left_out, explainer, drives, status, glance,
panel, json_lines, display, beside."""
