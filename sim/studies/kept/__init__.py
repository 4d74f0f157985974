"""What the folder of a study keeps: ``flight_log`` has what was found on every flight, ``flight_cache`` the flights."""
