"""Figures as plain values, and what draws them.

``figure`` is a drawing with its panels and axes, ``marks`` what lies in a panel, ``scales`` linear and logarithmic axes
with their ticks; ``colours`` are maps from numbers to colours, ``contours`` the lines and regions of a height.
``svg`` writes a drawing into a page, with ``shapes``, ``looks`` and ``paths`` for its marks and ``legends`` for the
places of their names; ``matplotlib_backend`` draws the same value for files of any other format.
"""
