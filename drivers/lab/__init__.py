"""Tables into ticks: lab, sheet, names, columns, numerals, stamps, counting, order, doubts; and frame_table."""
