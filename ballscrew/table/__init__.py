"""What a review has found, tick by tick, as a table for other tools, `review --table FILE.csv|.parquet`: table."""
