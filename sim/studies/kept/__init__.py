"""What is kept of a study: ``flight_log`` has what was found on every flight, ``flight_cache`` the flights themselves;
``finished`` remembers that all is done.
"""
