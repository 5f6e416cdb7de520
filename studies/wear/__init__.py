"""Contact and Archard's wear on any compliance."""
