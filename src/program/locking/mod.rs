//! Lock files: `lock` writes what runs gave, and `check --locked` compares with it.

mod findings;
pub(crate) mod lock;
mod lock_summary;
pub(crate) mod locked_check;
pub(crate) mod locked_runs;
mod moved;
