"""Glistin, Panasyuk: the azimuth aided by downlinked load factors.

``cases`` are the flights and conditions, ``tuning`` the parameters of the filters on seeds that no row reports,
``experiment`` the azimuth with and without load factors; ``claims`` measures, ``figures`` redraws figure 1.
"""
