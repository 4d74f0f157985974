"""Figures as plain values, and what draws them.

``figure`` is a drawing with its panels and axes, ``marks`` what lies in a panel, ``scales`` linear and logarithmic axes
with their ticks; ``colours`` are maps from numbers to colours, ``contours`` the lines and regions of a height.
``svg`` writes a drawing into a page, with ``paths`` and ``shapes`` for its marks, ``legends`` and ``letters`` for its
words; ``matplotlib_backend`` draws the same value for files of any other format.
"""
