"""Tables into ticks: lab, sheet, names, columns, numerals, stamps, counting, order, doubts, signals.

CSVs that are none of a lab: frame_table, estimates.
"""
