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

# case_times PRESET LABEL LOG: one line "SECONDS s  PRESET LABEL, PROGRAM: CASE" for each case (and section) of the log.
case_times() {
  awk -v run="$1 $2" '
    /^[0-9]+\/[0-9]+ Test: /  { program = $3 }
    /^[0-9]+\.[0-9]+ s: /     { seconds = $1; sub(/^[^:]*: /, ""); printf "%8.1f s  %s, %s: %s\n", seconds, run, program, $0 }
  ' "$3"
}

# slowest_cases N: of such lines on standard input the N with the longest times, longest first.
slowest_cases() { sort -s -k1,1nr | sed -n "1,$1p"; }
