"""Tables of approaches as they are flown: ``vectored`` is their route, ``navigation`` the errors that they are flown
with.
"""
