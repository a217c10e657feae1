"""Controllers, which compute commands from states, references and goals."""
