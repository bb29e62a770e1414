//! Text read from files, made safe to show. A manifest or a recording may contain any characters: those that move the cursor,
//! that reverse the direction of the text after them, or that a CI system executes as a command.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::path::Path;

/// Whether a character changes the appearance of other text instead of having its own: a control character, a mark that
/// changes the direction of text (Unicode Technical Report 36, section 2.1), a line separator, or a noncharacter, which XML 1.0
/// does not allow.
fn is_hidden(character: char) -> bool {
    matches!(character,
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{206f}' | '\u{feff}'
        | '\u{fdd0}'..='\u{fdef}')
        || character.is_control()
        || u32::from(character) & 0xfffe == 0xfffe
}

/// Whether a character has a place in text of several lines.
const fn is_layout(character: char) -> bool {
    matches!(character, '\n' | '\t')
}

fn escape(text: &str, is_escaped: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_escaped) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len() + 8);
    for character in text.chars() {
        if is_escaped(character) {
            escaped.extend(character.escape_default());
        } else {
            escaped.push(character);
        }
    }
    Cow::Owned(escaped)
}

/// Escapes control and bidirectional characters, as in `\u{1b}`. Line feeds and tabs stay.
#[must_use]
pub fn visible(text: &str) -> Cow<'_, str> {
    escape(text, |character| is_hidden(character) && !is_layout(character))
}

/// Escapes control and bidirectional characters, line feeds and tabs: the text stays within its line.
#[must_use]
pub fn one_line(text: &str) -> Cow<'_, str> {
    escape(text, is_hidden)
}

/// The start of a long text, with an ellipsis.
#[must_use]
pub fn shortened(text: &str, most_characters: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most_characters) {
        Some((end, _)) => Cow::Owned(format!("{}…", &text[..end])),
        None => Cow::Borrowed(text),
    }
}

/// Formats a count with its noun, such as "1 run" or "3 runs".
#[must_use]
pub fn plural(count: u64, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// What is repeated at a distance, such as "every frame", "every 2nd frame" or "every 11th frame".
#[must_use]
pub fn every(distance: u64, what: &str) -> String {
    let ending = match (distance % 100, distance % 10) {
        (11..=13, _) => "th",
        (_, 1) => "st",
        (_, 2) => "nd",
        (_, 3) => "rd",
        _ => "th",
    };
    if distance == 1 { format!("every {what}") } else { format!("every {distance}{ending} {what}") }
}

/// A path as messages show it: within its line, because a folder's name may contain a line feed and after it anything.
#[must_use]
pub fn shown_path(path: &Path) -> String {
    one_line(&path.display().to_string()).into_owned()
}

/// A word of a shell with control characters, as `$'…'`, which bash and zsh read; `None` for a word without any.
#[must_use]
pub fn escaped_word(word: &str) -> Option<String> {
    word.contains(is_hidden).then(|| {
        let mut escaped = String::from("$'");
        for character in word.chars() {
            match character {
                '\\' | '\'' => escaped.extend(['\\', character]),
                '\n' => escaped += "\\n",
                // Writing to a String cannot fail.
                _ if is_hidden(character) => {
                    let _ = write!(escaped, "\\U{:08x}", u32::from(character));
                }
                _ => escaped.push(character),
            }
        }
        escaped + "'"
    })
}

/// Escapes text for XML and HTML, in an element or an attribute. Characters that XML 1.0 does not allow are escaped as by
/// [`visible`].
#[must_use]
pub fn xml(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in visible(text).chars() {
        match character {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\'' => escaped += "&#39;",
            // A reader would replace them by spaces in an attribute.
            '\n' => escaped += "&#10;",
            '\t' => escaped += "&#9;",
            other => escaped.push(other),
        }
    }
    // A log that shows the text contains no command either.
    escaped.replace("##", "#&#35;")
}

/// Escapes the strings of a JSON text, which JSON itself escapes only in part. The text keeps its meaning.
#[must_use]
pub fn json(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        if is_hidden(character) && !is_layout(character) {
            for unit in character.encode_utf16(&mut [0; 2]) {
                // Writing to a String cannot fail.
                let _ = write!(escaped, "\\u{unit:04x}");
            }
        } else {
            escaped.push(character);
        }
    }
    // Two number signs occur within strings only.
    escaped.replace("##", "#\\u0023")
}

/// The openings of commands that CI systems execute wherever they are in a line of the output: GitHub, Azure and TeamCity.
const COMMANDS: [(&str, &str); 3] =
    [("##[", "#\\#["), ("##vso[", "#\\#vso["), ("##teamcity[", "#\\#teamcity[")];

/// Text for the output of a program: no control characters, and nothing that a CI system executes. GitHub executes lines that
/// begin with `::`, after any white space. With `has_styles`, the colors of a terminal stay.
#[must_use]
pub fn output(text: &str, has_styles: bool) -> String {
    let mut safe = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let line = if has_styles { styled(line) } else { visible(line).into_owned() };
        let content = line.trim_start();
        if content.starts_with("::") {
            safe += &line[..line.len() - content.len()];
            safe.push('\\');
            safe += content;
        } else {
            safe += &line;
        }
    }
    COMMANDS.iter().fold(safe, |text, (opening, escaped)| text.replace(opening, escaped))
}

/// Escapes a line as [`visible`] does, except for the escape sequences of colors: ESC, `[`, digits and semicolons, `m`.
fn styled(line: &str) -> String {
    let mut parts = line.split('\x1b');
    let mut safe = visible(parts.next().unwrap_or_default()).into_owned();
    for part in parts {
        let arguments = part.strip_prefix('[').map_or("", |rest| {
            let end = rest.find(|letter: char| !letter.is_ascii_digit() && letter != ';');
            end.map_or("", |end| if rest[end..].starts_with('m') { &part[..end + 2] } else { "" })
        });
        safe += if arguments.is_empty() { "\\u{1b}" } else { "\x1b" };
        safe += &visible(part);
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOSTILE: &str = "a\x1b[31m\u{7}\u{9b}\r\u{202e}\u{2066}\u{fffe}\u{2028}b";
    const ESCAPED: &str = "a\\u{1b}[31m\\u{7}\\u{9b}\\r\\u{202e}\\u{2066}\\u{fffe}\\u{2028}b";

    #[test]
    fn hidden_characters_are_escaped_everywhere() {
        assert_eq!(visible(HOSTILE), ESCAPED);
        assert_eq!(one_line(&format!("{HOSTILE}\n\t")), format!("{ESCAPED}\\n\\t"));
        assert_eq!(xml(HOSTILE), ESCAPED);
        assert_eq!(output(HOSTILE, false), ESCAPED);
        assert_eq!(visible("μ = 3 · 10⁻⁴ Å\n\t✓ 你好 עברית"), "μ = 3 · 10⁻⁴ Å\n\t✓ 你好 עברית");
    }

    #[test]
    fn distances_are_ordinal_numbers() {
        for (distance, expected) in [
            (1, "every frame"),
            (2, "every 2nd frame"),
            (3, "every 3rd frame"),
            (7, "every 7th frame"),
            (11, "every 11th frame"),
            (21, "every 21st frame"),
            (100, "every 100th frame"),
            (112, "every 112th frame"),
        ] {
            assert_eq!(every(distance, "frame"), expected);
        }
    }

    #[test]
    fn markup_is_escaped_for_xml() {
        assert_eq!(
            xml("<a b=\"c\" d='e'>&\n"),
            "&lt;a b=&quot;c&quot; d=&#39;e&#39;&gt;&amp;&#10;"
        );
    }

    #[test]
    fn no_line_is_a_command_of_a_ci_system() {
        let text = "::error::a\n \u{a0}::stop-commands::x\na ::b\n##[error]c\nd ##vso[task]e";
        let safe =
            "\\::error::a\n \u{a0}\\::stop-commands::x\na ::b\n#\\#[error]c\nd #\\#vso[task]e";
        assert_eq!(output(text, false), safe);
        assert_eq!(output(text, true), safe);
    }

    #[test]
    fn only_colors_pass_to_a_terminal() {
        assert_eq!(output("\x1b[1;31mred\x1b[0m", true), "\x1b[1;31mred\x1b[0m");
        assert_eq!(output("\x1b[2Ja\x1b]0;b\x1b", true), "\\u{1b}[2Ja\\u{1b}]0;b\\u{1b}");
        // A style before the colons does not hide them from the test for commands: CI systems see no styles.
        assert_eq!(output("\x1b[1m::error::", false), "\\u{1b}[1m::error::");
    }

    #[test]
    fn json_keeps_its_meaning() {
        let document = format!("{{\n \"a\": \"\u{7f}{}##[b]\"\n}}", '\u{202e}');
        assert_eq!(json(&document), "{\n \"a\": \"\\u007f\\u202e#\\u0023[b]\"\n}");
    }
}
