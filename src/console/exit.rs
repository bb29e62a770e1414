//! How a program ends.

use std::process::ExitCode;

/// How the program ends. The numbers are documented and do not change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Everything requested exists.
    Done,
    /// A run failed and would fail again.
    RunFailed,
    /// The manifest, the arguments, or a path that they name are wrong: the same command fails again.
    BadInput,
    /// A run ended otherwise than expected, a check failed or its metric is missing, or a metric differs from the baseline.
    CheckFailed,
    /// The compared recordings differ.
    Differs,
    /// A recording, or a part of it, cannot be read or is missing.
    Unreadable,
    /// A disk or another input or output failed.
    Retryable,
    /// Ended by a signal; the code is 128 plus its number.
    Signal(u8),
}

impl Exit {
    /// The number that the shell sees.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::RunFailed => 1,
            Self::BadInput => 2,
            Self::CheckFailed => 3,
            Self::Differs => 4,
            Self::Unreadable => 5,
            Self::Retryable => 75,
            Self::Signal(code) => code,
        }
    }

    /// The worse of two exit codes: what a retry cannot repair is worse than what it can.
    #[must_use]
    pub fn worst(self, other: Self) -> Self {
        if other.severity() > self.severity() { other } else { self }
    }

    const fn severity(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Retryable => 1,
            Self::BadInput => 2,
            Self::Unreadable => 3,
            Self::CheckFailed => 4,
            Self::Differs => 5,
            Self::RunFailed => 6,
            Self::Signal(_) => 7,
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit.code())
    }
}

#[cfg(test)]
mod tests {
    use super::Exit;

    #[test]
    fn worst_exit_code_does_not_depend_on_the_order() {
        let ascending = [Exit::Done, Exit::Retryable, Exit::BadInput, Exit::RunFailed];
        for (index, &low) in ascending.iter().enumerate() {
            for &high in &ascending[index..] {
                assert_eq!((low.worst(high), high.worst(low)), (high, high));
            }
        }
    }
}
