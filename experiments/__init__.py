"""The experiments of the paper, a short script each on the public API."""
