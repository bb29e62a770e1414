//! Output in ASCII, for terminals, logs and programs that read nothing else: `KINETOSCOPE_ASCII=1`.

use std::iter::Peekable;
use std::str::Chars;
use std::sync::LazyLock;

/// Whether the user asked for ASCII.
static REQUESTED: LazyLock<bool> = LazyLock::new(|| {
    std::env::var_os("KINETOSCOPE_ASCII").is_some_and(|value| !value.is_empty() && value != "0")
});

/// The text as the user wants it.
pub(crate) fn as_requested(text: String) -> String {
    if *REQUESTED && !text.is_ascii() { ascii(&text) } else { text }
}

/// The text with ASCII only: powers of ten as `e-18`, other exponents behind a caret, Greek letters by their names, and what has no such
/// form escaped as in `\u{597d}`. Columns that spaces separate stay aligned.
fn ascii(text: &str) -> String {
    let mut written = String::with_capacity(text.len());
    // How many columns were lost since spaces last made up for them; negative for columns that were added.
    let mut lost: isize = 0;
    let mut rest = text.chars().peekable();
    let mut was_exponent = false;
    while let Some(character) = rest.next() {
        let before = written.len();
        let mut read = 1;
        let exponent = exponent_of(character);
        match character {
            ' ' if rest.peek() == Some(&' ') => {
                while rest.next_if_eq(&' ').is_some() {
                    read += 1;
                }
                let spaces = if written.ends_with('\n') { read } else { (read + lost).max(2) };
                written.extend(std::iter::repeat_n(' ', usize::try_from(spaces).unwrap_or(2)));
            }
            '·' if skip_power_of_ten(&mut rest) => {
                read += 2;
                written.push('e');
            }
            _ if exponent.is_some() => {
                if !was_exponent && !written.ends_with('e') {
                    written.push('^');
                }
                written.extend(exponent);
            }
            _ if character.is_ascii() => written.push(character),
            _ => match name_of(character) {
                Some(name) => written += name,
                None => written.extend(character.escape_unicode()),
            },
        }
        was_exponent = exponent.is_some();
        let added = isize::try_from(written.len() - before).unwrap_or(0);
        lost = if character == '\n' { 0 } else { lost + read - added };
    }
    written
}

/// Skips the "10" of a power of ten, such as in ·10⁻¹⁸.
fn skip_power_of_ten(rest: &mut Peekable<Chars<'_>>) -> bool {
    let mut ahead = rest.clone();
    let is_power = ahead.next() == Some('1')
        && ahead.next() == Some('0')
        && ahead.next().is_some_and(|next| exponent_of(next).is_some());
    if is_power {
        rest.next();
        rest.next();
    }
    is_power
}

/// The character that a superscript raises.
const fn exponent_of(character: char) -> Option<char> {
    Some(match character {
        '⁻' => '-',
        '⁰' => '0',
        '¹' => '1',
        '²' => '2',
        '³' => '3',
        '⁴' => '4',
        '⁵' => '5',
        '⁶' => '6',
        '⁷' => '7',
        '⁸' => '8',
        '⁹' => '9',
        _ => return None,
    })
}

const fn name_of(character: char) -> Option<&'static str> {
    Some(match character {
        '±' => "+-",
        '·' => "*",
        '×' => "x",
        '−' | '–' => "-",
        '→' => "->",
        '…' => "...",
        '✓' => "ok",
        '√' => "sqrt",
        '⟨' => "<",
        '⟩' => ">",
        '’' => "'",
        '“' | '”' => "\"",
        '°' => " degrees",
        '₀' => "_0",
        '₁' => "_1",
        '₂' => "_2",
        '₄' => "_4",
        '₅' => "_5",
        '₆' => "_6",
        'α' => "alpha",
        'Δ' => "Delta",
        'ε' => "epsilon",
        'ζ' => "zeta",
        'η' => "eta",
        'θ' => "theta",
        'λ' => "lambda",
        'μ' | 'µ' => "mu",
        'ν' => "nu",
        'π' => "pi",
        'σ' => "sigma",
        'Σ' => "sum",
        'τ' => "tau",
        'φ' => "phi",
        'χ' => "chi",
        'ω' => "omega",
        'Ω' => "Omega",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::ascii;

    #[test]
    fn numbers_keep_their_values_in_ascii() {
        let text = "(1.3185 ± 0.0016)·10⁻¹⁸ N/m, 3·10⁴ m²/s², φ = 0.7, 10⁻³, 好\n";
        let expected = "(1.3185 +- 0.0016)e-18 N/m, 3e4 m^2/s^2, phi = 0.7, 10^-3, \\u{597d}\n";
        assert_eq!(ascii(text), expected);
        assert_eq!(ascii("plain  text\n  indented"), "plain  text\n  indented");
    }

    #[test]
    fn columns_stay_aligned_in_ascii() {
        let table = "  a  1.5·10⁻¹⁸ N  x\n  b  1.5 N        y\n  c  ± 2          z\n";
        assert!(table.lines().all(|line| line.chars().count() == 19));
        assert!(ascii(table).lines().all(|line| line.len() == 19), "{}", ascii(table));
    }
}
