"""Work in pieces that may be interrupted and resumed.  Imports `storage`."""
