# Progress of a build in a few lines: reads what ninja or make print, writes one line per tenth.
#   cmake --build ... | awk -v what=LAMMPS -f cmake/progress.awk
# (Where ninja looks for new files first, it counts to 1 or 2 before the build itself: not shown.)
match($0, /^\[ *[0-9]+(\/[0-9]+|%)\]/) {
  text = substr($0, 2, RLENGTH - 2)
  if (split(text, count, "/") == 2) {
    if (count[2] < 10) next
    tenth = int(10 * count[1] / count[2])
  } else
    tenth = int(text / 10)
  if (tenth > last) {
    printf "DEFE:   %s %d %%\n", what, 10 * tenth
    fflush()
    last = tenth
  }
}
