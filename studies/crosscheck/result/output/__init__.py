"""Write the files of the commands, and read results back."""
