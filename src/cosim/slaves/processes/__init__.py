"""Slaves that run elsewhere: in a process of their own, behind a stream on this machine or another; the protocol between."""
