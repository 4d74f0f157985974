"""Read: a TOML file becomes a validated ``Scenario``, all its faults told at once."""
