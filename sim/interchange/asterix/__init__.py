"""ASTERIX, the format of surveillance data [EUROCONTROL-SPEC-0149], in and out.

The codec: ``items`` has the forms of data items, ``category`` what a category is, `categories` those that are known;
``encoding`` makes records of columns and ``decoding`` columns of records, ``blocks`` frames them as data blocks and
``pcap`` as datagrams in a capture. What it is for: ``reading`` opens a file, ``plots`` gives recorded plots,
``tracks`` estimates and recorded flights, and ``writing`` makes messages of plots and tracks.
"""
