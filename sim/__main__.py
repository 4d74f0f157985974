"""``python -m sim`` is the command ``shortfinal``."""

from sim.cli.commands import main

if __name__ == "__main__":
    main()
