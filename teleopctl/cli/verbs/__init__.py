"""Verbs of the command line: a module or package each, imported when the verb is used."""
