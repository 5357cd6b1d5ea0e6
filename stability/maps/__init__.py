"""Parameter grids: verdicts and growth rates over two axes."""
