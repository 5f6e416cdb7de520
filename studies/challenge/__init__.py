"""The wear challenge: sixteen problems with certified numbers, which any program can try."""
