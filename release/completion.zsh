# Prints what an interactive zsh makes of the argument and Tab, up to the word that is expected in it.
# Usage: completion.zsh INPUT EXPECTED
zmodload zsh/zpty
zpty shell zsh -f -i || exit 1
zpty -w shell 'PROMPT=; autoload -Uz compinit; compinit -u -D; print rea"dy"'
zpty -r shell output '*ready*'
zpty -w -n shell "$1"$'\t'
output=
repeat 200; do
    while zpty -r -t shell piece; do output+=$piece; done
    [[ $output == *$2* ]] && break
    sleep 0.1
done
print -rn -- "$output"
zpty -d shell
