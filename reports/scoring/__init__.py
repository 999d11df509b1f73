"""Somebody else's result: read into one form, put beside a reference, judged by the same metrics, its likely faults named."""
