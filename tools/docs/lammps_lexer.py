"""Colours of LAMMPS input: commands, IDs, strings, variables, numbers, comments."""

from pygments.lexer import RegexLexer, bygroups
from pygments.token import Comment, Keyword, Name, Number, String, Text, Whitespace


class LAMMPSLexer(RegexLexer):
    name = "LAMMPS"
    aliases = ["LAMMPS", "lammps"]
    tokens = {
        "root": [
            (r"#.*", Comment),
            (r"&[ \t]*\n[ \t]*\S+", Text),  # the next line goes on: its first word is no command
            (r"^([ \t]*)(fix|compute|dump|region|variable|group)([ \t]+)(\S+)",
             bygroups(Whitespace, Keyword, Whitespace, Name.Variable)),
            (r"^([ \t]*)([a-z_]+)(?=\s)", bygroups(Whitespace, Keyword)),
            (r'"[^"\n]*"|\'[^\'\n]*\'', String),
            (r"\$\{[^}]*\}|\$\([^)\n]*\)|\$[a-z]", Name.Variable),
            (r"[-+]?\d+(\.\d*)?([eE][-+]?\d+)?(?=[\s&]|$)", Number),
            (r"\s+", Whitespace),
            (r"[^\s#\"'$]+|.", Text),
        ],
    }
