# SPDX-License-Identifier: MIT
# Fills @OPTIONS@ of a manual page with the flags that --help lists, so that the two cannot differ.
# Usage: awk -f options.awk HELP PAGE
function plain(text) { gsub(/\\/, "\\e", text); gsub(/-/, "\\-", text); return text }
# A flag's line is indented by two and has its text after two spaces; deeper lines go on with it.
NR == FNR && /^  -/ {
    line = substr($0, 3)
    at = match(line, /  +/)
    options = options ".TP\n.B " plain(substr(line, 1, at - 1)) "\n" plain(substr(line, at + RLENGTH)) "\n"
    next
}
NR == FNR && /^      / { sub(/^ +/, ""); options = options plain($0) "\n"; next }
NR == FNR { next }
/^@OPTIONS@$/ { printf "%s", options; next }
{ print }
