//! What all programs print and how they end: messages, standard output, exit codes, and the escaping of text that was read from files.

mod ascii;
pub mod calendar;
mod exit;
mod internal_error;
mod message;
mod standard_output;
pub mod text;
mod threads;
mod wrap;

pub use exit::Exit;
pub use internal_error::{INTERNAL_ERROR, catch_internal_errors};
pub use message::{Explained, Message};
pub use standard_output::{StandardOutput, complain};
pub use threads::{ON_MISSING_THREAD, can_start_thread, start_threads};
pub use wrap::{without_styles, wrapped_line};
