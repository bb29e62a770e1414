//! Lines wrapped at the width of a terminal, between words.

/// Words that begin a message.
const LABELS: [&str; 4] = ["error: ", "help: ", "note: ", "warning: "];

/// Wraps a line at `width` columns; further lines are indented by `indent` spaces. A word that is longer than a line stays whole,
/// so that a path can be copied. Escape sequences of colors have no width.
#[must_use]
pub fn wrapped_line(line: &str, width: usize, indent: usize) -> String {
    wrapped_after("", line, width, indent)
}

/// Wraps the words of `line` behind a beginning that stays as it is.
fn wrapped_after(beginning: &str, line: &str, width: usize, indent: usize) -> String {
    let (mut text, mut column) = (beginning.to_owned(), columns(beginning));
    for word in line.split(' ').filter(|word| !word.is_empty()) {
        let length = columns(word);
        if text.is_empty() {
            column = length;
        } else if column + 1 + length > width {
            text.push('\n');
            text += &" ".repeat(indent);
            column = indent + length;
        } else {
            text.push(' ');
            column += 1 + length;
        }
        text += word;
    }
    text
}

/// Wraps the messages among the lines: those that begin with `error:` or `help:`, whose further lines are aligned with the first
/// word after the colon, and the labels of underlined places. Other lines, such as those of a manifest, stay as they are.
pub(crate) fn wrapped_messages(text: &str, width: usize) -> String {
    let lines = text.split('\n').map(|line| {
        let plain = without_styles(line);
        if plain.chars().count() <= width {
            return line.to_owned();
        }
        if let Some(label) = LABELS.iter().find(|label| plain.starts_with(**label)) {
            return wrapped_line(line, width, label.len());
        }
        match line.split_once('^').filter(|_| plain.trim_start().starts_with("| ")) {
            Some((gutter, marked)) => {
                let (marks, label) = marked.split_once(' ').unwrap_or((marked, ""));
                let beginning = format!("{gutter}^{marks}");
                // Below the marks: a label that begins far to the right has more room there.
                wrapped_after(&beginning, label, width, columns(gutter))
            }
            None => line.to_owned(),
        }
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Wraps all lines of a text; further lines are indented by two spaces more than the first one. Rows of a table, whose cells are apart by
/// several spaces, stay as they are.
pub(crate) fn wrapped_text(text: &str, width: usize) -> String {
    let lines = text.split('\n').map(|line| {
        let content = line.trim_start_matches(' ');
        if columns(line) <= width || content.contains("  ") {
            return line.to_owned();
        }
        let indent = line.len() - content.len();
        let (first, rest) = content.split_once(' ').unwrap_or((content, ""));
        wrapped_after(&format!("{}{first}", " ".repeat(indent)), rest, width, indent + 2)
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Columns that a text takes.
fn columns(text: &str) -> usize {
    without_styles(text).chars().count()
}

/// The text without escape sequences of colors: ESC, `[`, parameters, `m`.
#[must_use]
pub fn without_styles(text: &str) -> String {
    let mut parts = text.split("\x1b[");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |plain, part| plain + part.split_once('m').map_or(part, |(_, rest)| rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_wrapped_between_words_and_aligned() {
        let text = "error: the manifest cannot be read\n  | source lines stay as they are\nhelp: name a/very/long/path/of/a/file";
        let expected = "error: the manifest\n       cannot be read\n  | source lines stay as they are\nhelp: name\n      a/very/long/path/of/a/file";
        assert_eq!(wrapped_messages(text, 21), expected);
    }

    #[test]
    fn lines_of_a_text_keep_their_indentation() {
        let text = "gas: 2 runs\n  5 discs, at most 3 MiB\na  row  of  a  table\n";
        let expected = "gas: 2 runs\n  5 discs, at\n    most 3 MiB\na  row  of  a  table\n";
        assert_eq!(wrapped_text(text, 14), expected);
        assert_eq!(wrapped_text(text, 24), text);
    }

    #[test]
    fn lines_that_fit_are_not_changed() {
        let text = "error: two  spaces\nhelp: none";
        assert_eq!(wrapped_messages(text, 18), text);
        assert_ne!(wrapped_messages(text, 17), text);
    }

    #[test]
    fn labels_are_wrapped_below_their_marks() {
        let text = "4 | speed = 3\n  | ^^^^^ known keys: mass, radius";
        let expected = "4 | speed = 3\n  | ^^^^^ known keys:\n    mass, radius";
        assert_eq!(wrapped_messages(text, 22), expected);
        let colored = "  \x1b[94m|\x1b[0m \x1b[91m^^\x1b[0m \x1b[91mout of range\x1b[0m";
        let expected = "  \x1b[94m|\x1b[0m \x1b[91m^^\x1b[0m \x1b[91mout of\n    range\x1b[0m";
        assert_eq!(wrapped_messages(colored, 14), expected);
    }

    #[test]
    fn colors_have_no_width() {
        let text = "\x1b[1m\x1b[91merror\x1b[0m\x1b[1m: it is unknown\x1b[0m";
        assert_eq!(wrapped_messages(text, 20), text);
        let expected = "\x1b[1m\x1b[91merror\x1b[0m\x1b[1m: it is\n       unknown\x1b[0m";
        assert_eq!(wrapped_messages(text, 19), expected);
    }
}
