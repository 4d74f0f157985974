"""A module for each category that is read and written, with its items: ``cat021`` position reports of ADS-B,
``cat034`` service messages of a radar, ``cat048`` its target reports, ``cat062`` system tracks. ``units`` has
what several share.
"""
