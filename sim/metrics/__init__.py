"""Judge: figures of a flight and of its trackers, and checks of these against limits.

``signals`` are what can be asked of a flight at every instant, ``table`` has one row for each of its figures, which
``figures`` work out and ``flight`` puts together; ``windshear`` is the F-factor. ``comparison`` brings truth and
estimates to common channels, ``tracker`` counts the errors there, ``error_curves`` has them over time, ``conformance``
asks whether the law is followed, ``navigation`` how good the estimate was that was flown on. ``checks`` are limits with
their margins on one flight. The room ``contrasts`` sets two trackers against each other, the room ``alarms`` is about
what watches a tracker, its false alarms and delays; the room ``arrivals`` measures turns onto final; the room
``ensemble`` is about several flights, and has the verdict on each check.
"""
