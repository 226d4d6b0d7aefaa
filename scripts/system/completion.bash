# Completion of Stillgrid's programs for bash. Options are those that have a line of --help; values are completed
# where they are known: scenes, devices, transitions, sessions, files.

# The folder PREFIX of the program that is completed.
_stillgrid_prefix() {
  local program
  program=$(type -P -- "$1") && dirname -- "$(dirname -- "$(readlink -f -- "$program")")"
}

# Names of the files PREFIX/FOLDER/*SUFFIX. Arguments: program, FOLDER, SUFFIX.
_stillgrid_names() {
  local prefix file
  prefix=$(_stillgrid_prefix "$1") || return 0
  for file in "$prefix/$2"/*"$3"; do
    if [[ -e $file ]]; then basename -- "$file" "$3"; fi
  done
}

_stillgrid_sessions() {
  local file
  for file in "/dev/shm/stillgrid-$EUID"/*; do
    file=${file##*/}
    if [[ $file == *[-+]* ]]; then echo "${file%-*}"; fi
  done
}

_stillgrid() {
  local cur prev words cword
  _init_completion -n : || return
  local program=${words[0]}
  case $prev in
    --scene)
      _filedir toml
      return
      ;;
    --device)
      # Of scene_fit and fit_run it is whose hand presses.
      case ${program##*/} in
        scene_fit) mapfile -t COMPREPLY < <(compgen -W "touch touchx premium15" -- "$cur") ;;
        *)
          mapfile -t COMPREPLY < <(compgen -W "$(_stillgrid_names "$program" lib/stillgrid/devices .so)" -- "$cur")
          if [[ $cur == */* ]]; then _filedir so; fi
          ;;
      esac
      return
      ;;
    --transition)
      mapfile -t COMPREPLY < <(compgen -W "$("$program" --help 2>/dev/null |
        sed -n 's/.*--transition TEXT:{\([a-z,]*\)}.*/\1/p' | tr , ' ')" -- "$cur")
      return
      ;;
    --session)
      mapfile -t COMPREPLY < <(compgen -W "$(_stillgrid_sessions)" -- "$cur")
      return
      ;;
    --interface) _available_interfaces; return ;;
    --group) mapfile -t COMPREPLY < <(compgen -g -- "$cur"); return ;;
    --*)
      # With a value, by --help; an option of one program may be a flag of another.
      if "$program" --help 2>/dev/null | grep -qE -- "^ *$prev [A-Z]"; then
        _filedir
        return
      fi
      ;;
  esac
  if [[ $cur == -* ]]; then
    local subcommand=()
    if [[ ${program##*/} == scene_relay && $cword -gt 1 ]]; then subcommand=("${words[1]}"); fi
    mapfile -t COMPREPLY < <(compgen -W "$("$program" "${subcommand[@]}" --help 2>/dev/null |
      sed -nE 's/^ {1,8}(-.*)/\1/p' | sed 's/  .*//' | grep -oE -- '--[a-z][a-z-]*' | sort -u)" -- "$cur")
    return
  fi
  case ${program##*/} in
    scene_relay)
      if ((cword == 1)); then mapfile -t COMPREPLY < <(compgen -W "simulation hand ros" -- "$cur"); fi
      ;;
    stillgrid_launch | replay_check | scene_fit | stiffness_fit)
      _filedir
      if ((cword == 1)); then
        mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY \
          < <(compgen -W "$(_stillgrid_names "$program" share/stillgrid/scenes .toml)" -- "$cur")
      fi
      ;;
    device_check)
      mapfile -t COMPREPLY < <(compgen -W "$(_stillgrid_names "$program" lib/stillgrid/devices .so)" -- "$cur")
      if [[ $cur == */* ]]; then _filedir so; fi
      ;;
    *) _filedir ;;
  esac
}

complete -F _stillgrid sim_server haptic_server segment_inspect scene_viewer scene_relay device_check \
  sphere_decompose replay_check scene_fit stiffness_fit stillgrid_import stillgrid_launch stillgrid_demo
