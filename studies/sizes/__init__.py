"""Sizes of meshes and steps that an accuracy asks for, and which problems share them."""
