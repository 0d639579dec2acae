"""Tables into ticks: lab, sheet, names, columns, numerals, stamps, counting, order, doubts; frame_table, estimates."""
