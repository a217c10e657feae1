"""From a description and its arguments to a plan: substitutions, scopes, parameters."""
