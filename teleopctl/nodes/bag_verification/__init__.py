"""Verification of a bag: simulate the recorded launch again, and compare the messages."""
