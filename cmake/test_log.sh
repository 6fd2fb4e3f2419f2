# Sourced by ./check: reads what ctest leaves of test programs that were run with "-d yes".

# counts_of LOG: "PASSED FAILED". A program that ends without a summary (a crash, a time-out) counts as one failed case.
counts_of() {
  awk '
    /^[0-9]+\/[0-9]+ Test: /         { programs++ }
    /^All tests passed \(/           { ended++; for (i = 1; i < NF; i++) if ($(i + 1) ~ /^test$/) passed += $i }
    /^test cases:.*\|/               { ended++; for (i = 1; i < NF; i++) { if ($(i + 1) == "passed") passed += $i
                                                                        if ($(i + 1) == "failed") failed += $i } }
    /^No tests ran/                  { ended++ }
    END { print passed + 0, failed + programs - ended + 0 }' "$1"
}

# case_times PRESET LABEL LOG: one line "SECONDS s  PRESET LABEL, PROGRAM: CASE" for each case of the log. Sections have
# lines, too; a case that is run once for each of its sections is added up.
case_times() {
  awk -v run="$1 $2" '
    /^[0-9]+\/[0-9]+ Test: /  { program = $3 }
    /^[0-9]+\.[0-9]+ s: /     { seconds = $1; sub(/^[^:]*: /, ""); times[program ": " $0] += seconds }
    END { for (name in times) printf "%8.1f s  %s, %s\n", times[name], run, name }
  ' "$3"
}

# slowest_cases N: of such lines on standard input the N with the longest times, longest first.
slowest_cases() { sort -k1,1nr -k2 | sed -n "1,$1p"; }
