"""The elastic ground in theory: layers bonded on a substrate or on a rigid base."""
