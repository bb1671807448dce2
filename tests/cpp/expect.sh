#!/usr/bin/env bash
# expect.sh REGEX COMMAND...: the command must succeed and print this; line breaks count as spaces.
set -uo pipefail
regex=$1
shift
output=$("$@" 2>&1)
status=$?
printf '%s\n' "$output"
[ $status = 0 ] || { echo "exit status $status"; exit 1; }
tr '\n' ' ' <<< "$output" | grep -Eq "$regex" || { echo "does not print: $regex"; exit 1; }
