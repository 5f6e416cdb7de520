"""The wear challenge: twelve problems with certified numbers, for any program to try."""
