"""Extreme parameters: true errors over promised ones, beside a naive solver."""
