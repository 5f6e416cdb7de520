"""The theory of the elastic ground: layers bonded to a substrate or to a rigid base."""
