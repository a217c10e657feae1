"""Completion scripts of the shells, and the format of their requests and of our answers.

Each shell has a script, printed by ``teleopctl completion SHELL``, that runs teleopctl with
``_TELEOPCTL_COMPLETE`` set to the shell's name and passes the command line after a ``--``. Bash
passes the line up to the cursor as typed, and its word breaks, so teleopctl handles the quotes. Zsh
and fish pass words without quotes, and quote candidates themselves. PowerShell cannot pass words
that contain quotes as arguments, so its script passes them in an environment variable.

No blank is added after a candidate that ends with one of ``=/.``, which the user continues.
"""

from __future__ import annotations

import os

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

# NAME stands for the command that is completed, and CALL for the one that is called for it.
BASH = """\
_NAME_completion() {
    local candidate
    COMPREPLY=()
    while IFS= read -r candidate; do
        COMPREPLY+=("$candidate")
    done < <(_TELEOPCTL_COMPLETE=bash CALL -- "${COMP_LINE:0:$COMP_POINT}" "$COMP_WORDBREAKS")
    [[ ${COMPREPLY[0]-} == *[=/.] ]] && compopt -o nospace 2>/dev/null
    return 0
}
complete -F _NAME_completion NAME"""

ZSH = """\
#compdef NAME
_NAME() {
    local -a candidates
    candidates=("${(@f)$(_TELEOPCTL_COMPLETE=zsh CALL -- \\
        "${(@Q)words[2,CURRENT-1]}" "${(Q)PREFIX}")}")
    candidates=(${candidates:#})
    compadd -- ${candidates:#*[=/.]}
    compadd -S '' -- ${(M)candidates:#*[=/.]}
}
if [[ ${funcstack[1]-} == _NAME ]]; then
    _NAME "$@"
else
    (( $+functions[compdef] )) || { autoload -Uz compinit && compinit }
    compdef _NAME NAME
fi"""

FISH = """\
function __NAME_complete
    set -l words (commandline --current-process --tokenize --cut-at-cursor)
    set -l current (commandline --current-token --cut-at-cursor)
    _TELEOPCTL_COMPLETE=fish CALL -- $words[2..-1] "$current"
end
complete --command NAME --no-files --arguments "(__NAME_complete)\""""

POWERSHELL = """\
Register-ArgumentCompleter -Native -CommandName NAME -ScriptBlock {
    param($wordToComplete, $commandAst, $cursorPosition)
    $words = @($commandAst.CommandElements |
        Select-Object -Skip 1 |
        Where-Object { $_.Extent.EndOffset -lt $cursorPosition } |
        ForEach-Object {
            if ($_ -is [System.Management.Automation.Language.StringConstantExpressionAst]) {
                $_.Value
            } else {
                $_.Extent.Text
            }
        })
    $Env:_TELEOPCTL_COMPLETE = "powershell"
    $Env:_TELEOPCTL_WORDS = ($words + "$wordToComplete") -join [char]31
    $program = CALL
    try {
        & $program | ForEach-Object {
            [System.Management.Automation.CompletionResult]::new($_, $_, "ParameterValue", $_)
        }
    } finally {
        Remove-Item -Path Env:_TELEOPCTL_COMPLETE
        Remove-Item -Path Env:_TELEOPCTL_WORDS
    }
}"""

# How each script calls the program that the user has typed, by path or not.
_TYPED = {
    "bash": '"$1"',
    "zsh": '"${(Q)words[1]}"',
    "fish": "$words[1]",
    "powershell": "$commandAst.GetCommandName()",
}
_SCRIPTS = {"bash": BASH, "zsh": ZSH, "fish": FISH, "powershell": POWERSHELL}
_PROGRAM = "teleopctl"


def script(shell: str, name: str = _PROGRAM) -> str:
    """Return the completion script of a shell.

    Args:
        shell: Name of the shell.
        name: Command to complete. Under another name than teleopctl's own it may be an alias,
            which a script cannot call, so that teleopctl is called for it.
    """
    call = _TYPED[shell] if name == _PROGRAM else _PROGRAM
    if shell == "powershell" and name != _PROGRAM:
        call = f'"{_PROGRAM}"'
    return _SCRIPTS[shell].replace("NAME", name).replace("CALL", call)


_BLANKS = " \t\n"
_SPECIAL = frozenset(" \t\"'\\$&()*;<>?[]^{|}~#!`")


class CompletionRequest:
    """Completion request of a shell: the words of a command line up to the cursor.

    Attributes:
        words: Words before the last one, without the program's name and without quotes.
        incomplete: Beginning of the last word, without quotes.
        quote: Quote character that is open at the cursor; "" for none.
        kept: Number of characters of ``incomplete`` that the shell keeps; it inserts the rest of a
            candidate after them.
    """

    __slots__ = ("incomplete", "kept", "quote", "words")

    def __init__(
        self, words: Sequence[str], incomplete: str, quote: str = "", kept: int = 0
    ) -> None:
        self.words = words
        self.incomplete = incomplete
        self.quote = quote
        self.kept = kept


def parse_request(shell: str, words: Sequence[str]) -> CompletionRequest | None:
    """Return a shell's completion request; None for an unknown shell or missing words.

    Args:
        shell: Name of the shell: ``bash``, ``zsh``, ``fish`` or ``powershell``.
        words: Words after the program's name.
    """
    given = list(words[1:] if words[:1] == ["--"] else words)
    if shell == "powershell":
        given = os.environ.get("_TELEOPCTL_WORDS", "").split("\x1f")
        given[-1] = _without_powershell_quotes(given[-1])
    elif shell == "bash" and len(given) == 2:
        asked = split_line(given[0], given[1])
        return CompletionRequest(asked.words[1:], asked.incomplete, asked.quote, asked.kept)
    elif shell == "fish" and given:
        given[-1] = split_line(given[-1]).incomplete
    elif shell != "zsh" or not given:
        return None
    return CompletionRequest(given[:-1], given[-1])


def _without_powershell_quotes(word: str) -> str:
    """Remove the quotes of a PowerShell word, which has no escaped characters."""
    quote = word[:1]
    return word[1:].removesuffix(quote) if quote in ("'", '"') else word


def split_line(line: str, breaks: str = "") -> CompletionRequest:
    """Split a line as a POSIX shell does; return a request, whose last quote may be open.

    Args:
        line: Command line up to the cursor, as typed.
        breaks: Characters after which the shell begins a new word for completion.
    """
    words: list[str] = []
    word: str | None = None  # None between two words
    quote = ""
    kept = 0
    characters = iter(line)
    for character in characters:
        if quote:
            if character == quote:
                quote = ""
            elif character == "\\" and quote == '"':
                following = next(characters, "")
                word = f"{word}{'' if following in _ESCAPED_IN_QUOTES else character}{following}"
            else:
                word = f"{word}{character}"
        elif character in _BLANKS:
            if word is not None:
                words.append(word)
            word, kept = None, 0
        elif character in "\"'":
            quote, word = character, word or ""
            kept = len(word)
        elif character == "\\":
            word = (word or "") + next(characters, "")
        else:
            word = (word or "") + character
            if character in breaks:
                kept = len(word)
    return CompletionRequest(words, word or "", quote, kept if breaks else 0)


_ESCAPED_IN_QUOTES = frozenset('\\"$`')


def format_candidate(shell: str, request: CompletionRequest, candidate: str) -> str:
    """Return a candidate quoted for a shell's script; for Bash, without the part it keeps."""
    if shell == "powershell":
        is_plain = all(letter.isalnum() or letter in "/_-.:=~" for letter in candidate)
        return candidate if is_plain else "'" + candidate.replace("'", "''") + "'"
    if shell != "bash":
        return candidate
    rest = candidate[request.kept :]
    if request.quote == "'":
        return rest.replace("'", "'\\''")
    if request.quote:
        return "".join(f"\\{each}" if each in _ESCAPED_IN_QUOTES else each for each in rest)
    if request.incomplete or _SPECIAL.isdisjoint(rest):
        return "".join(f"\\{each}" if each in _SPECIAL else each for each in rest)
    # Nothing of the word has been typed, so the whole candidate gets the most readable quotes.
    if "'" not in rest:
        return f"'{rest}'"
    if not _ESCAPED_IN_QUOTES.intersection(rest) and "!" not in rest:
        return f'"{rest}"'
    return "'" + rest.replace("'", "'\\''") + "'"
