"""The results of a run: numbers, the table and the summary, independent of how they are shown."""
