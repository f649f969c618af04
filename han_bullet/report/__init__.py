"""Pages that a stranger can read: one run, a sweep of runs, and the paper's figures from our own layers and stages."""
