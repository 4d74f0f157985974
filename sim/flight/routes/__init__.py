"""Kinds of route: ``kind`` is their contract, ``kinds`` finds that of a scenario.

``pattern``, ``legs`` and ``vectored`` are one each.
"""
