"""``shortfinal export``: what a run, a study or a scenario leaves for other programs.

``asked`` knows which options go with which format, ``formats`` how a table is written, ``records`` the arrays of a
folder as they are and the flights of a study, ``spreadsheet`` the tables that a person reads, ``others`` the formats of
other programs.
"""
