"""Control laws: a file here is the ``kind`` of ``[autopilot]``; its contract is `autopilot.mode`."""
