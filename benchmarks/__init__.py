"""Benchmarks: each prints its own Markdown table; `python -m benchmarks` writes them all to RESULTS.md."""
