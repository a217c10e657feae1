"""The verbs: a file or folder each, imported when the verb is named."""
