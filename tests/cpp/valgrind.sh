#!/usr/bin/env bash
# Runs a command under valgrind and fails when a report has a frame of ours: PCL, OpenCV and what they load leave
# memory behind at the end, which is theirs. What they call from `main` is theirs too: the innermost frames tell.
set -uo pipefail
log=$(mktemp)
trap 'rm -f "$log"' EXIT
suppressions=$(dirname "$0")/../c/valgrind.supp
valgrind --error-exitcode=99 --leak-check=full --errors-for-leak-kinds=definite,indirect,possible --num-callers=12 \
    --suppressions="$suppressions" --log-file="$log" "$@"
status=$?
[ $status = 0 ] && exit 0
if [ $status != 99 ]; then
    cat "$log"
    exit $status
fi
# A report is a paragraph; of its frames those up to the sixth count: deeper ones only say who called a library.
awk '
    { sub(/^==[0-9]+== ?/, "") }
    /^ *$/ { if (ours) { print report; bad = 1 } report = ""; ours = 0; frames = 0; next }
    { report = report $0 "\n" }
    /^ *(at|by) 0x/ { if (++frames <= 6 && /cylfuse|\(test_|\(check\.hpp|\(0[1-7]_|\(frame\.hpp|\(second_unit/) ours = 1 }
    END { if (ours) { print report; bad = 1 } exit bad }
' "$log"
