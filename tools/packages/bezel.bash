# Completion for bezel in bash: options, their values, and decks.
_bezel() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}
  COMPREPLY=()
  case $before in
    -o) mapfile -t COMPREPLY < <(compgen -d -- "$word") ; return ;;
    --list) mapfile -t COMPREPLY < <(compgen -W 'elements materials contacts commands' -- "$word") ; return ;;
    --restart) mapfile -t COMPREPLY < <(compgen -f -X '!*.h5' -- "$word" ; compgen -d -- "$word") ; return ;;
    --name | --set | --threads | --time-limit) return ;;
  esac
  case $word in
    -*) mapfile -t COMPREPLY < <(compgen -W '-o --name --set --check --restart --threads --time-limit --quiet --list --version --help' -- "$word") ;;
    *) mapfile -t COMPREPLY < <(compgen -f -X '!*.inp' -- "$word" ; compgen -d -- "$word") ;;
  esac
}
complete -o filenames -F _bezel bezel
_bezel_post() {
  local word=${COMP_WORDS[COMP_CWORD]}
  COMPREPLY=()
  if [ "$COMP_CWORD" = 1 ]; then
    mapfile -t COMPREPLY < <(compgen -W 'curve convergence field contact-map mesh diff' -- "$word")
  else
    mapfile -t COMPREPLY < <(compgen -f -- "$word")
  fi
}
complete -o filenames -F _bezel_post bezel-post
