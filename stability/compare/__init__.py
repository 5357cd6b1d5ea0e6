"""Cost against error, and where methods fail: routes to one answer, compared on this machine."""
