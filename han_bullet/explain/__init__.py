"""Why is nobody known here, and which layer moved the way? Answers of a finished run, from its files alone."""
