"""Quality of service: the flags, the text of ``info``, and which ends do not fit."""
