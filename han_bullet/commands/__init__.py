"""The subcommands of `han-bullet`, one module per subject; each has `add(commands)`, which adds its parsers."""
