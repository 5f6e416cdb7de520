"""Mistakes that people make, each a hypothesis that predicts what a program then prints."""
