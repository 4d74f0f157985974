"""Everything that is wrong with a scenario file, of all layers at once, each fault with its line.

- ``faults`` - reads as much of a file as can be read, and gathers what every layer says of it
- ``sound`` - takes out what faults are about, so that every layer can be asked again
- ``lines`` - finds the line of a key in the text of a TOML file
"""
