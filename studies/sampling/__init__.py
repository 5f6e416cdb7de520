"""From histories to the quantities that are asked for, their norms, and the answer."""
