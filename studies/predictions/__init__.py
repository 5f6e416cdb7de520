"""What a run will take, in seconds and in memory, told before it runs."""
