"""Recorder of topics into a bag."""
