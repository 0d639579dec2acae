"""What a review has found, tick by tick, as a table for other tools: `review --table FILE.csv|.parquet`.

In the order to read them: columns, file.
"""
