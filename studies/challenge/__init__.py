"""The wear challenge: twelve problems with certified numbers, which any program can try."""
