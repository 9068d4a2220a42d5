# SPDX-License-Identifier: MIT
# docs/settings.md from the list of flags that the daemon prints:
#   build/draped --help | awk -f docs/settings.awk >docs/settings.md
# A flag's line is indented by two: "--name VALUE  meaning [default] (VARIABLE)"; deeper lines
# continue it.
BEGIN {
    print "# Settings\n"
    print "Each flag of `draped` has an environment variable; a flag wins over its variable. BYTES may end in K,"
    print "M or G (powers of 1024). `draped --check-config` checks all of them and stops. In a package they are"
    print "set in `/etc/default/draped`.\n"
    print "This page is made from `draped --help` by `docs/settings.awk`.\n"
    print "| flag | variable | default | meaning |"
    print "|---|---|---|---|"
}
function flush() {
    if (entry == "") return
    at = match(entry, /  +/)
    flag = substr(entry, 1, at - 1)
    meaning = substr(entry, at + RLENGTH)
    entry = variable = fallback = ""
    if (match(meaning, / \(DRAPED_[A-Z_]+\)$/)) {
        variable = "`" substr(meaning, RSTART + 2, RLENGTH - 3) "`"
        meaning = substr(meaning, 1, RSTART - 1)
    }
    if (match(meaning, / \[[^][]*\]$/)) {
        fallback = "`" substr(meaning, RSTART + 2, RLENGTH - 3) "`"
        meaning = substr(meaning, 1, RSTART - 1)
    }
    gsub(/\|/, "\\|", flag)
    if (variable != "") printf "| `--%s` | %s | %s | %s |\n", substr(flag, 3), variable, fallback, meaning
    else others = others sprintf("| `--%s` | %s |\n", substr(flag, 3), meaning)
}
/^  -/ { flush(); entry = substr($0, 3); next }
/^      / && entry != "" { sub(/^ +/, " "); entry = entry $0; next }
{ flush() }
END {
    flush()
    print "\nFlags that do one thing and end:\n\n| flag | |\n|---|---|"
    printf "%s", others
}
