"""The command ``shortfinal``: its sub-commands, and the text that each prints."""
