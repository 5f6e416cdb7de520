"""The paper, again."""
