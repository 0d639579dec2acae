"""Who does long work: threads for what is small, processes that keep recordings, or the workers of a Dask scheduler;
what travels to them: processes, cluster, by_value."""
