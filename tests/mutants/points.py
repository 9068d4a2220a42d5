# SPDX-License-Identifier: MIT
"""The small mistakes that could be made in a C file, found by its tokens as clang-format lays them
out: an operator with two operands stands between blanks, one with a single operand touches it.

A comparison is made stricter, laxer or turned; a whole number becomes its neighbour, another one
twice itself or, when it is written with an exponent, as tolerances are, a thousand times; a sum
becomes a difference, a product a quotient; `and` becomes `or`; a sign or a negation goes; a
condition is turned, which swaps the branches; a statement goes. What only frees memory, makes or takes
a lock stays, and how many calloc makes: that it is missing is what the sanitizers say."""
import bisect
import dataclasses
import re

TOKEN = re.compile(r"""
    (?P<comment>/\*.*?\*/|//[^\n]*) | (?P<directive>^[ \t]*\#(?:[^\n\\]|\\.)*$)
  | (?P<string>"(?:[^"\\]|\\.)*"|'(?:[^'\\]|\\.)*') | (?P<name>[A-Za-z_]\w*)
  | (?P<number>\.?\d(?:[eEpP][+-]|[\w.])*)
  | (?P<sign><<=|>>=|\.\.\.|->|\+\+|--|&&|\|\||<<|>>|[-+*/%&|^<>=!]=|[^\s\w])
""", re.VERBOSE | re.MULTILINE | re.DOTALL)

OTHERS = {"<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<"),
          "==": ("!=",), "!=": ("==",), "&&": ("||",), "||": ("&&",),
          "+": ("-",), "-": ("+",), "*": ("/",), "/": ("*",), "%": ("*",),
          "&": ("|",), "|": ("&",), "^": ("|",), "<<": (">>",), ">>": ("<<",),
          "+=": ("-=",), "-=": ("+=",), "*=": ("/=",), "/=": ("*=",), "|=": ("&=",), "&=": ("|=",)}
COMPARISONS = ("<", "<=", ">", ">=", "==", "!=")
STEPS = {"++": "--", "--": "++"}
WORDS = {"true": "false", "false": "true"}
CONTROL = {"if", "else", "for", "while", "do", "switch", "case", "default", "return", "goto"}
DECLARES = {"struct", "enum", "union", "const", "static", "extern", "typedef", "_Static_assert", "sizeof"}
FREES = re.compile(r"\w*(free|decref|destroy|clear|mutex_lock|mutex_init)\w*\s*\(")
TYPES = re.compile(r"enum|_Static_assert|typedef|struct|extern")


@dataclasses.dataclass
class Token:
    kind: str
    text: str
    at: int
    end: int
    body: bool  # within a function


@dataclasses.dataclass
class Point:
    """A place of a file and what may stand there instead."""
    kind: str
    at: int
    end: int
    others: tuple
    line: int
    body: bool


def tokens_of(source):
    """Without comments, directives and the heads of functions, whose numbers are sizes of arguments."""
    tokens, body, head = [], False, 0
    for match in TOKEN.finditer(source):
        if match.lastgroup in ("comment", "directive"):
            continue
        first = match.start() == 0 or source[match.start() - 1] == "\n"
        if first and match[0] not in "{}":
            head = function_head(source, match.start())
            body = head > 0
        if match.start() >= head:
            tokens.append(Token(match.lastgroup, match[0], match.start(), match.end(), body))
    return tokens


def function_head(source, at):
    """Where the head of a function that begins there ends; 0: none does. A body follows it."""
    head = re.compile(r"[^;={]*").match(source, at)
    return head.end() if source[head.end():].startswith("{") and head[0].rstrip().endswith(")") else 0


def number_points(token):
    digits = token.text.rstrip("uUlLfF") if not token.text.lower().startswith("0x") else token.text
    if re.fullmatch(r"\d+", digits):
        value = int(digits)
        return tuple(str(other) for other in (value + 1, value - 1) if other >= 0)
    if re.fullmatch(r"\d+[eE][+-]?\d+|\d*\.\d+[eE][+-]?\d+", digits):
        return (f"{float(digits) * 1000:g}",)
    if re.fullmatch(r"\d*\.\d*", digits):
        return (f"{2 * float(digits) or 1.0:.15g}",)
    return ()


def blank(source, at):
    return source[at:at + 1] in (" ", "\n")


def operator_point(source, before, token):
    """The kind of an operator, where it is, and what may stand in its place."""
    binary = blank(source, token.at - 1) and blank(source, token.end)
    kind, others = "arithmetic", ()
    if token.text in OTHERS and binary:
        others = OTHERS[token.text]
        if token.text in COMPARISONS:
            kind = "comparison"
        elif token.text in ("&&", "||"):
            kind = "logic"
    elif token.text in STEPS:
        others = (STEPS[token.text],)
    elif token.text in "-!" and not binary and not (before and before.text == "!"):
        kind, others = "sign" if token.text == "-" else "logic", ("",)
    return kind, token.at, token.end, others


def matching(tokens, k):
    """Of the parenthesis at k, the place of the other one."""
    depth = 0
    for n in range(k, len(tokens)):
        depth += {"(": 1, ")": -1}.get(tokens[n].text, 0)
        if depth == 0:
            return n
    return k


def statement_end(tokens, k):
    """The semicolon that ends the statement that begins at k; None: it is no such statement."""
    for n in range(k, len(tokens)):
        if tokens[n].text in "{}":
            return None
        if tokens[n].text == ";":
            return n
    return None


def is_statement(tokens, k):
    """Whether an assignment, a call, or a jump begins there."""
    first, second = tokens[k], tokens[k + 1]
    if first.text in ("break", "continue"):
        return True
    if first.text in CONTROL | DECLARES or first.kind not in ("name", "sign") or first.text in "{};":
        return False
    if first.kind == "sign":
        return first.text in ("*", "(", "++", "--")
    return second.kind == "sign" and second.text not in (":", "*")


def ends_head(source, token, after):
    """Whether a parenthesis ends the head of a loop or a branch: a new line follows."""
    return token.text == ")" and "\n" in source[token.end:after.at]


def declares_type(source, token):
    return not token.body and TYPES.fullmatch(token.text) and source[:token.at].endswith("\n")


def declaration_end(tokens, k):
    """Where what begins there and is no function ends."""
    depth = 0
    for token in tokens[k:]:
        depth += {"{": 1, "}": -1}.get(token.text, 0)
        if token.text == ";" and depth == 0:
            break
    return token.end


def points_of(source):
    """All of a file's points, in its order."""
    tokens, points = tokens_of(source), []
    lines = [match.start() for match in re.finditer("\n", source)]
    starts, depth, typed = True, 0, 0  # a statement may begin; parentheses; a type's declaration ends
    sizes = False  # numbers are those of arrays that are declared

    def add(kind, at, end, others):
        if others:
            points.append(Point(kind, at, end, others, bisect.bisect(lines, at) + 1, token.body))

    for k, token in enumerate(tokens[:-1]):
        if declares_type(source, token):
            typed = declaration_end(tokens, k)
        if token.at < typed:
            continue
        if token.body and starts and depth == 0:
            sizes = not is_statement(tokens, k) and (
                token.text in ("struct", "const", "static") or tokens[k + 1].kind == "name"
                or tokens[k + 1].text == "*") and token.text not in CONTROL
            end = statement_end(tokens, k) if is_statement(tokens, k) else None
            if end and not FREES.match(source[token.at:tokens[end].at].removeprefix("(void)")):
                add("statement", token.at, tokens[end].at, ("",))
        made = k > 1 and tokens[k - 2].text == "calloc"
        if token.kind == "number" and not sizes and not made:
            add("constant", token.at, token.end, number_points(token))
        elif token.text in WORDS:
            add("constant", token.at, token.end, (WORDS[token.text],))
        elif token.kind == "sign":
            sizes = sizes and token.text not in "=;"
            add(*operator_point(source, tokens[k - 1] if k else None, token))
        if token.body and token.text == "if":
            first, last = tokens[k + 1].end, tokens[matching(tokens, k + 1)].at
            add("branch", first, last, (f"!({source[first:last]})",))
        depth += {"(": 1, ")": -1}.get(token.text, 0)
        starts = token.text in ("{", "}", ";", "else", "do") or ends_head(source, token, tokens[k + 1])
    return points
