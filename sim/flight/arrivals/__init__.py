"""Approaches as they are flown: ``vectoring`` lays out the vectors of a scenario and the final that they lead to."""
