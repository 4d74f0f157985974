"""How an arrival turns onto its final: ``last_turn`` measures one flight, flown or recorded, ``look_alike`` compares
many with the distributions of others.
"""
