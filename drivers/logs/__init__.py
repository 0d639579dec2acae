"""Files of frames and tables: readers, writers, and the truth beside them.

In the order to read them: logs, candump, candump_line, python_can, outside, outside_reader, every_frame, labcsv,
joined, truth, log_writer, mf4_writer.
"""
