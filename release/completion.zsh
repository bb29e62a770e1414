# Prints what an interactive zsh makes of the argument and Tab.
zmodload zsh/zpty
zpty shell zsh -f -i
zpty -w shell 'PROMPT=; autoload -Uz compinit; compinit -u -D; print rea"dy"'
zpty -r shell output '*ready*'
zpty -w -n shell "$1"$'\t'
sleep 2
while zpty -r -t shell output; do print -rn -- "$output"; done
zpty -d shell
