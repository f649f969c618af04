"""han_bullet: human-aware navigation that sees people."""
