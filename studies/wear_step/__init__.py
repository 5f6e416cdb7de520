"""The longest stable step of programs that update the worn profile explicitly on their own mesh."""
