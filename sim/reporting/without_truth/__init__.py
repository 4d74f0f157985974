"""What a page says of tracks of which no truth is known: ``figures`` and ``tables`` from the plots alone."""
