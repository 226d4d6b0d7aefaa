# Sourced: what a long command does, and what is left. On a terminal one line that is written over, elsewhere
# a line every STILLGRID_PROGRESS_S seconds (default 10).

progress_told_s=$SECONDS

# progress TEXT: shows it.
progress() {
  if [ -t 2 ]; then
    printf '\r\033[K%.*s' "$(($(tput cols 2>/dev/null || echo 80) - 1))" "$1" >&2
  elif [ $((SECONDS - progress_told_s)) -ge "${STILLGRID_PROGRESS_S:-10}" ]; then
    progress_told_s=$SECONDS
    printf '%s\n' "$1" >&2
  fi
}

# progress_end: the line is free again.
progress_end() {
  if [ -t 2 ]; then printf '\r\033[K' >&2; fi
}

# time_left DONE TOTAL START_S: what the rest takes if it goes on as since START_S (of SECONDS).
time_left() {
  local done=$1 total=$2 passed_s=$((SECONDS - $3)) left_s
  if [ "$passed_s" -lt 5 ] || [ "$done" -eq 0 ]; then return; fi
  left_s=$((passed_s * (total - done) / done))
  printf ', about %d:%02d min left' $((left_s / 60)) $((left_s % 60))
}
