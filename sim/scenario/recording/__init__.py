"""A recorded flight in a scenario: ``table`` is ``[record]``, ``completion`` what it brings along, and refuses.

``plots_alone`` is about sensors that recorded their looks, and flights that only these tell of.
"""
