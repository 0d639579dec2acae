"""Tables of a lab into ticks: lab, sheet, names, columns, numerals, stamps, counting, order; and frame_table."""
