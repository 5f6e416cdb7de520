"""What all studies share: levels, orders, figures of errors, and the value that a study returns."""
