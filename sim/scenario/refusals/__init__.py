"""What the faults of a scenario leave to be asked, and how they are told.

- ``files`` - files near one that is not there
- ``sound`` - the part of a file that its broken tables leave
- ``units`` - ranges in the unit that the user wrote
"""
