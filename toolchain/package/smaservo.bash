# shellcheck shell=bash
# Completes smaservod and host-sim from what their own --help says.

# The subcommands, or the options, that a command's help lists.
_smaservo_words() {
  local kind=$1
  shift
  "$@" --help 2>/dev/null | awk -v kind="$kind" '
    /^Subcommands:/ { inside = 1; next }
    /^[^ ]/ { inside = 0 }
    kind == "commands" && inside && /^  [a-z]/ { print $1 }
    kind == "options" && /^ +-/ { n = split($1, names, ","); for (i = 1; i <= n; ++i) if (names[i] ~ /^--/)
      { sub(/[{=:].*/, "", names[i]); print names[i] } }'
}

_smaservo() {
  local current=${COMP_WORDS[COMP_CWORD]} i word words
  local -a command=("${COMP_WORDS[0]}")
  COMPREPLY=()
  for ((i = 1; i < COMP_CWORD; ++i)); do
    word=${COMP_WORDS[i]}
    if [[ $word == [a-z]* ]] && _smaservo_words commands "${command[@]}" | grep -qxF -- "$word"; then
      command+=("$word")
    fi
  done
  if [[ $current == -* ]]; then
    words=$(_smaservo_words options "${command[@]}")
  else
    words=$(_smaservo_words commands "${command[@]}")
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
}

complete -o default -F _smaservo smaservod host-sim
