"""Files of frames and tables: readers, writers, and the truth beside them.

In the order to read them: logs, candump, candump_line, lines, python_can, outside, outside_reader, every_frame,
joined, truth, log_writer, mf4_writer.
"""
