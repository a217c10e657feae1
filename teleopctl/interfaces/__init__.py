"""Floor 0: message, service and action types, their CDR, hashes and YAML."""
