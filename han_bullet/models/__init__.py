"""Trained weights, each with a card that says from what and how well."""
