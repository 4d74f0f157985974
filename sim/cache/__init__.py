"""What one command leaves for the next: ``user_cache`` keeps it in the cache folder of the user, or nowhere."""
