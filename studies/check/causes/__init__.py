"""Mistakes that people often make, each as a hypothesis that predicts what the program prints."""
