"""A recorded flight in a scenario: ``table`` is ``[record]``, ``completion`` what it brings along, and refuses."""
