//! A message for the user: what is wrong, and the one thing to do. The two are separate from the start, so that no code looks for
//! a remedy in the prose of an error.

use std::fmt::{self, Display, Formatter};

/// What is wrong, and what to do. As text, the help is on a line of its own, as printed after `error: `.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Message {
    /// What is wrong, without a period at its end. Lines of details may follow the first one.
    pub what: String,
    /// The one thing to do; `None` if there is nothing to do, or if `what` contains complete errors, such as those of a manifest.
    pub help: Option<String>,
}

impl Message {
    /// A message with help.
    #[must_use]
    pub fn new(what: impl Into<String>, help: impl Into<String>) -> Self {
        Self { what: what.into(), help: Some(help.into()) }
    }

    /// The message about one of several subjects, such as a run of a sweep.
    #[must_use]
    pub fn about(self, subject: impl Display) -> Self {
        Self { what: format!("{subject}: {}", self.what), ..self }
    }

    /// The message as one clause, where it is a part of a line or of a document.
    #[must_use]
    pub fn clause(&self) -> String {
        match &self.help {
            Some(help) => format!("{}; {help}", self.what),
            None => self.what.clone(),
        }
    }
}

impl Display for Message {
    fn fmt(&self, text: &mut Formatter<'_>) -> fmt::Result {
        text.write_str(&self.what)?;
        self.help.as_ref().map_or(Ok(()), |help| write!(text, "\nhelp: {help}"))
    }
}

/// A message without help.
impl From<String> for Message {
    fn from(what: String) -> Self {
        Self { what, help: None }
    }
}

/// A message without help.
impl From<&str> for Message {
    fn from(what: &str) -> Self {
        what.to_owned().into()
    }
}

/// An error that knows the user's next step. Its own text states only what is wrong.
pub trait Explained: Display {
    /// The one thing to do.
    fn help(&self) -> Option<String>;

    /// What is wrong, and what to do.
    fn message(&self) -> Message {
        Message { what: self.to_string(), help: self.help() }
    }
}

#[cfg(test)]
mod tests {
    use super::Message;

    /// Neither part is read for sentences: what is wrong may contain colons and periods, and so may the help.
    #[test]
    fn parts_of_a_message_stay_as_they_are() {
        let message = Message::new("it fails: at 1.5 m. Badly", "take a: b; or c. D");
        assert_eq!(message.to_string(), "it fails: at 1.5 m. Badly\nhelp: take a: b; or c. D");
        assert_eq!(message.clause(), "it fails: at 1.5 m. Badly; take a: b; or c. D");
        let message = message.about("n = 3");
        assert_eq!(message.what, "n = 3: it fails: at 1.5 m. Badly");
        assert_eq!(Message::from("it fails").to_string(), "it fails");
    }
}
