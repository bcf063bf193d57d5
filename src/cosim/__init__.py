"""The master: it couples components through their signals, and knows none of them by name."""
