"""The cheapest way over a costmap."""
