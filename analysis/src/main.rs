//! `analyze-recordings`: arguments to exit code, nothing else.

fn main() {}
